"""Predicted against measured speeds along the tracks, and the force that the speeds tell of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.axes import terciles
from avahazard.inference.nodes import SPEED_CORRELATION_M
from avahazard.inference.posterior import Posterior
from avahazard.inference.predicted import Predicted
from avahazard.inference.study import LEFT, SpeedRecord, Study
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.constants import GRAVITY
from avahazard.physics.runout_table import MU, MU_STEP

Floats = NDArray[np.float64]

N_TABLES = 24
DRAWS_A_TABLE = 25
MIN_PIECE_M = 20.0
"""Shortest stretch over which a deceleration is taken: over less, errors of speed drown it."""


@dataclass(frozen=True, slots=True, eq=False)
class MatchedSpeeds:
    """Speeds at every measured place of all tracks, m/s.

    `draws` `[n_places, n_draws]` hold the model's and the measurement's error; `event`, `x` (m),
    `observed` and `sigma` are `[n_places]`.
    """

    event: NDArray[np.int64]
    x: Floats
    observed: Floats
    sigma: Floats
    draws: Floats


def matched_speeds(
    posterior: Posterior,
    coordinates: Floats,
    offsets: Floats | None,
    rng: np.random.Generator,
) -> MatchedSpeeds | None:
    """Draw speeds of each track with the friction that its own stop asks for; None without tracks.

    The friction of an event is drawn given its recorded stop and its volume, not its speeds, so
    that the misfit is that of the motion alone. `coordinates` `[n_draws, n_slots]` and
    `offsets` `[n_draws, n_groups]` are draws of the posterior.
    """
    study = posterior.study
    if not study.speeds:
        return None
    chosen = np.linspace(0, len(coordinates) - 1, N_TABLES).round().astype(np.int64)
    shaped = bool(posterior.layout.tables)
    tables = None if shaped else posterior.predicted_at(coordinates[chosen[0]])
    columns = []
    for k in chosen:
        u = coordinates[k]
        table = posterior.predicted_at(u) if tables is None else tables
        given = None if offsets is None else offsets[k]
        tracks = [
            _track_draws(posterior, table, u, given, j, rng) for j in range(len(study.speeds))
        ]
        columns.append(np.concatenate(tracks, axis=0))
    return MatchedSpeeds(
        event=np.concatenate([np.full(len(t.x), t.event) for t in study.speeds]),
        x=np.concatenate([t.x for t in study.speeds]),
        observed=np.concatenate([t.speed for t in study.speeds]),
        sigma=np.concatenate([t.sigma for t in study.speeds]),
        draws=np.concatenate(columns, axis=1),
    )


def friction_given_stop(
    posterior: Posterior, table: Predicted, u: Floats, offsets: Floats | None, event: int
) -> Floats:
    """Probability of each friction of the grid given the event's stop `[n_friction]`."""
    study = posterior.study
    location, scatter = posterior.location_and_scatter(u)
    m, s = location[event], scatter[event]
    if posterior.groups is not None and offsets is not None and posterior.groups[event] >= 0:
        shift = offsets[posterior.groups[event]]
        m = m + shift if posterior.layout.log_scatter else m * np.exp(shift)
    place = np.log(MU) if posterior.layout.log_scatter else MU
    z2 = ((place[:, None] - m) / s) ** 2
    kernel = -2.5 * np.log1p(0.25 * z2) if posterior.specification.tails == "student" else -0.5 * z2
    # A step of the grid is shorter in log μ where μ is large.
    width = -np.log(MU) if posterior.layout.log_scatter else 0.0
    weight = study.volumes.weight[event]
    with np.errstate(divide="ignore"):
        log_p = np.logaddexp.reduce(kernel + np.log(weight / s), axis=1) + width
    left = table.status[event] == LEFT_PROFILE
    if study.kind[event] == LEFT:
        log_p = np.where(left, log_p, -np.inf)
    else:
        z = (table.record[event] - study.observed[event]) / study.sigma[event]
        log_p = np.where(left, -np.inf, log_p - 0.5 * z * z)
    if not np.any(np.isfinite(log_p)):
        log_p = np.where(left == (study.kind[event] == LEFT), 0.0, -np.inf)
    if not np.any(np.isfinite(log_p)):
        log_p = np.zeros(len(MU))
    p = np.exp(log_p - np.max(log_p))
    return np.asarray(p / np.sum(p))


def _track_draws(
    posterior: Posterior,
    table: Predicted,
    u: Floats,
    offsets: Floats | None,
    track: int,
    rng: np.random.Generator,
) -> Floats:
    """Speeds of one track by one draw of the parameters, `[n_speeds, DRAWS_A_TABLE]`."""
    measured = posterior.study.speeds[track]
    p = friction_given_stop(posterior, table, u, offsets, measured.event)
    mu = rng.choice(MU, DRAWS_A_TABLE, p=p) + MU_STEP * (rng.random(DRAWS_A_TABLE) - 0.5)
    speed = np.stack([np.interp(mu, MU, column) for column in table.speeds[track].T])
    scatter = 0.0
    if posterior.layout.speed_scatter is not None:
        scatter = float(np.exp(u[posterior.layout.speed_scatter]))
    apart = np.abs(measured.x[:, None] - measured.x[None, :])
    covariance = scatter**2 * np.exp(-apart / SPEED_CORRELATION_M) + np.diag(measured.sigma**2)
    noise = np.linalg.cholesky(covariance) @ rng.standard_normal(speed.shape)
    return np.asarray(speed + noise)


def measured_force(study: Study) -> list[dict[str, Any]]:
    """What resisted each track, g sinθ - u du/dξ, by stretches of at least 20 m.

    As Ancey and Meunier (2004): against speed, Coulomb friction is flat and a force of Voellmy's
    kind rises with its square. Rows `{"event_id", "x_m", "speed_m_s", "force_m_s2", "sd_m_s2",
    "slope_deg"}`; `sd_m_s2` comes from the errors of the speeds.
    """
    return [row for track in study.speeds for row in _forces(study, track)]


def _forces(study: Study, track: SpeedRecord) -> list[dict[str, Any]]:
    terrain = study.sites[int(study.columns.path_index[track.event])].terrain
    s, y = np.interp(track.x, terrain.x, terrain.s), np.interp(track.x, terrain.x, terrain.y)
    rows = []
    first = 0
    for last in range(1, len(s)):
        length = s[last] - s[first]
        if length < MIN_PIECE_M:
            continue
        u0, u1 = track.speed[first], track.speed[last]
        sine = (y[first] - y[last]) / length
        error = np.hypot(u0 * track.sigma[first], u1 * track.sigma[last]) / length
        rows.append(
            {
                "event_id": study.columns.event_id[track.event],
                "x_m": float(0.5 * (track.x[first] + track.x[last])),
                "speed_m_s": float(0.5 * (u0 + u1)),
                "force_m_s2": float(GRAVITY * sine - (u1**2 - u0**2) / (2.0 * length)),
                "sd_m_s2": float(error),
                "slope_deg": float(np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0)))),
            }
        )
        first = last
    return rows


def speed_misfit(study: Study, matched: MatchedSpeeds) -> list[dict[str, Any]]:
    """Rows `{"axis", "level", "n", "bias_m_s", "rmse_m_s"}` by place and by predicted speed.

    Thirds of the measured places. No p-value: speeds along a track go together.
    """
    error = matched.draws.mean(axis=1) - matched.observed
    rows = []
    for axis, levels in _levels(study, matched).items():
        for level in np.unique(levels[levels != ""]):
            mine = levels == level
            rows.append(
                {
                    "axis": axis,
                    "level": str(level),
                    "n": int(np.sum(mine)),
                    "bias_m_s": float(np.mean(error[mine])),
                    "rmse_m_s": float(np.sqrt(np.mean(error[mine] ** 2))),
                }
            )
    return rows


def _levels(study: Study, matched: MatchedSpeeds) -> Mapping[str, NDArray[np.str_]]:
    share = np.empty(len(matched.x))
    for event in np.unique(matched.event):
        mine = matched.event == event
        site = study.sites[int(study.columns.path_index[event])]
        span = site.smooth.x_max - site.smooth.x_min
        share[mine] = (matched.x[mine] - site.smooth.x_min) / span
    return {
        "place_along_path": terciles(share, lambda v: f"{v:.0%}"),
        # The predicted speed: the measured one would be high where its error is.
        "predicted_speed_m_s": terciles(matched.draws.mean(axis=1), lambda v: f"{v:.1f} m/s"),
    }
