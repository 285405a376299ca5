"""Predicted against measured speeds along the tracks, and the force that the speeds tell of."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from avahazard.arrays import Floats
from avahazard.criticism.scoring.where_it_fails import Levels, holm, terciles
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.nodes import Nodes, build_nodes
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.track_nodes import drawn_speeds
from avahazard.inference.model.friction_model import below, log_density
from avahazard.inference.model.observations import LEFT, Observations, SpeedRecord
from avahazard.notes import Note
from avahazard.physics.cells import GRAVITY
from avahazard.physics.runout_curve import MU, between, located, steps_of
from avahazard.results.base import Rows
from avahazard.results.comparison import MeasuredForce, SpeedMisfit

N_DRAWS, N_TABLES = 24, 12
"""Posterior draws, and as many where each has runs of every block for itself."""
N_SPEEDS = 600
"""Draws of each speed."""
FEWEST_TRACKS = 3
MIN_PIECE_M = 20.0
"""Shortest stretch over which a deceleration is taken: over less, errors of speed drown it."""
TINY = 1e-290


class MatchedSpeeds(NamedTuple):
    """Speeds at every measured place of all tracks, m/s.

    `draws` `[n_places, n_draws]` hold the model's and the measurement's error; `event`, `x` (m),
    `observed` and `sigma` are `[n_places]`.
    """

    event: NDArray[np.int64]
    x: Floats
    observed: Floats
    sigma: Floats
    draws: Floats


def track_places(observations: Observations) -> MatchedSpeeds:
    """The measured places of the tracks, one after the other, without draws."""
    tracks = observations.speeds
    rows = [(np.full(len(t.x), t.event), t.x, t.speed, t.sigma) for t in tracks]
    event, x, observed, sigma = map(np.concatenate, zip(*rows, strict=True))
    return MatchedSpeeds(event, x, observed, sigma, np.empty((0, 0)))


def matched_speeds(model: FittedModel, rng: np.random.Generator) -> MatchedSpeeds | None:
    """Draw speeds of each track with the friction that its own stop asks for; None without tracks.

    The friction of an event is drawn given its recorded stop and its volume, not its speeds, so
    that the misfit is that of the motion alone.
    """
    observations, posterior = model.observations, model.posterior
    if not observations.speeds:
        return None
    offsets = model.group_offsets(rng)
    shaped = bool(posterior.layout.tables)
    chosen = model.thinned(N_TABLES if shaped else N_DRAWS)
    per_draw = N_SPEEDS // len(chosen)
    columns: list[Floats] = []
    for k in chosen:
        u = model.draws[k]
        if shaped or not columns:
            table = posterior.nodes.predicted_at(u)
            nodes = stop_nodes(posterior, table)
        friction = posterior.friction_at(u, None if offsets is None else offsets[k])
        tracks = []
        sigma = posterior.layout.track_sigma(u)
        for j, track in enumerate(observations.speeds):
            i = track.event
            places, chance = friction_given_record(posterior, nodes, i, friction)
            square = _squares_at(table, j, i, rng.choice(places, per_draw, p=chance))
            arrives = observations.kind[i] != LEFT
            tracks.append(drawn_speeds(square, track, sigma, rng, arrives))
        columns.append(np.concatenate(tracks, axis=0))
    return track_places(observations)._replace(draws=np.concatenate(columns, axis=1))


def stop_nodes(posterior: Posterior, table: Predicted) -> Nodes:
    """Nodes over friction of the stops alone, without the speeds."""
    stops, table = replace(posterior.observations, speeds=()), replace(table, speeds=())
    return build_nodes(stops, table, in_log=posterior.layout.log_scatter)


def _squares_at(table: Predicted, track: int, event: int, mu: Floats) -> Floats:
    """Squares of speed at frictions `mu`, `[n_speeds, n_draws]`, between those of the table.

    The likelihood spreads records evenly over a jump, so the record may lie within one, or at the
    profile's end: then the block that came that far counts, brought to rest there (`TrackSpeeds`),
    not the one that stopped before.
    """
    discontinuous = table.curve[event].discontinuous
    cell, share = located(steps_of(mu), discontinuous)
    share = np.where(discontinuous[cell], 0.0, share)
    block = table.speeds[track]
    square = np.asarray([between(speed**2, cell, share) for speed in block.speed.T])
    return np.where(cell == block.cell, block.at_jump[:, None], square)


def measured_force(observations: Observations) -> Rows[MeasuredForce]:
    """What resisted each track, g sinθ - u du/dξ, by stretches of at least 20 m.

    As Ancey and Meunier (2004): against speed, Coulomb friction is flat and a force of Voellmy's
    kind rises with its square. `sd_m_s2` comes from the errors of the speeds.
    """
    return Rows(row for track in observations.speeds for row in _forces(observations, track))


def _forces(observations: Observations, track: SpeedRecord) -> Iterator[MeasuredForce]:
    terrain = observations.sites[int(observations.columns.path_index[track.event])].terrain
    s, y = np.interp(track.x, terrain.x, terrain.s), np.interp(track.x, terrain.x, terrain.y)
    first = 0
    for last in range(1, len(s)):
        length = s[last] - s[first]
        if length < MIN_PIECE_M:
            continue
        u0, u1 = track.speed[first], track.speed[last]
        sine = (y[first] - y[last]) / length
        error = np.hypot(u0 * track.sigma[first], u1 * track.sigma[last]) / length
        yield MeasuredForce(
            event_id=observations.columns.event_id[track.event],
            x_m=float(0.5 * (track.x[first] + track.x[last])),
            speed_m_s=float(0.5 * (u0 + u1)),
            force_m_s2=float(GRAVITY * sine - (u1**2 - u0**2) / (2.0 * length)),
            sd_m_s2=float(error),
            slope_deg=float(np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0)))),
        )
        first = last


def speed_misfit(observations: Observations, matched: MatchedSpeeds) -> Rows[SpeedMisfit]:
    """The misfit of the speeds by place and by predicted speed.

    Thirds of the measured places. Speeds along a track go together, so tracks are what is counted:
    their mean errors in a level against zero by Student's t, corrected for all levels (Holm).
    """
    error = matched.draws.mean(axis=1) - matched.observed
    rows = []
    for axis, (values, levels) in _levels(observations, matched).items():
        upwards = levels[np.argsort(values)]
        for level in dict.fromkeys(upwards[upwards != ""]):
            selected = levels == level
            rows.append(
                SpeedMisfit(
                    axis=axis,
                    level=Note.read(level),
                    n=int(np.sum(selected)),
                    bias_m_s=float(np.mean(error[selected])),
                    rmse_m_s=float(np.sqrt(np.mean(error[selected] ** 2))),
                    p_value=_by_track(error[selected], matched.event[selected]),
                )
            )
    corrected = iter(holm([p for row in rows if (p := row.p_value) is not None]))
    return Rows(
        row if row.p_value is None else replace(row, p_value=next(corrected)) for row in rows
    )


def _by_track(error: Floats, event: NDArray[np.int64]) -> float | None:
    """p-value of the tracks' mean errors; None with fewer than `FEWEST_TRACKS`."""
    means = np.array([np.mean(error[event == one]) for one in np.unique(event)])
    if (n := len(means)) < FEWEST_TRACKS:
        return None
    t = abs(np.mean(means)) / max(float(np.std(means, ddof=1)), 1e-12) * np.sqrt(n)
    return float(2.0 * stdtr(n - 1, -t))


def _levels(
    observations: Observations, matched: MatchedSpeeds
) -> Mapping[str, tuple[Floats, Levels]]:
    share = np.empty(len(matched.x))
    for event in np.unique(matched.event):
        selected = matched.event == event
        site = observations.sites[int(observations.columns.path_index[event])]
        span = site.smooth.x_max - site.smooth.x_min
        share[selected] = (matched.x[selected] - site.smooth.x_min) / span
    # The predicted speed: the measured one would be high where its error is.
    speed = matched.draws.mean(axis=1)
    return {
        "place_along_path": (share, terciles(share, ".0%")),
        "predicted_speed_m_s": (speed, terciles(speed, ".1f", " m/s")),
    }


def friction_given_record(
    posterior: Posterior, nodes: Nodes, event: int, friction: tuple[Floats, Floats, Floats]
) -> tuple[Floats, Floats]:
    """Frictions `[n_nodes + 2]` and their chances (which sum to 1) given the record of one event.

    The last two stand for all below and beyond the tables, which a vague record allows. `nodes` and
    `friction`, as `Posterior.friction_at` has it, are those of all events.
    """
    location, scatter, h = (of_all[event] for of_all in friction)
    in_log = posterior.layout.log_scatter
    place, weight = nodes.place[event], nodes.weight[event]
    if nodes.is_probability[event]:
        # Beyond the profile: any friction, by its probability of that.
        edges, drops = place, weight
        place = np.log(MU) if in_log else MU
        chance = nodes.floor[event] + (edges > place[:, None]) @ drops
        weight = np.gradient(place) * np.clip(chance, 0.0, 1.0)
    student = posterior.specification.tails == "student"
    z = (place[:, None] - location) / scatter
    log_p = np.logaddexp.reduce(log_density(z, student) + np.log(h / scatter), axis=1)
    edge = nodes.tail_place[event]
    z = np.array([[1.0], [-1.0]]) * (edge[:, None] - location) / scatter
    log_beyond = np.log(np.maximum(below(z, student) @ h, TINY))
    log_p = np.concatenate([log_p, log_beyond])
    place = np.concatenate([place, edge])
    weight = np.concatenate([weight, nodes.tail[event]])
    top = np.max(log_p[weight > 0.0], initial=-np.inf)
    p = weight * np.exp(np.minimum(log_p - top, 0.0))
    if not np.sum(p) > 0.0:
        p = np.ones(len(place))
    return (np.exp(place) if in_log else place), p / np.sum(p)
