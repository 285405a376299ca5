"""Worlds made from a fitted model on the user's own design: the parametric bootstrap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.criticism.screening.seen_friction import draw_seen_friction
from avahazard.criticism.screening.speed_points import Tracks
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.sight import hidden_from
from avahazard.inference.likelihood.speed_errors import drawn_speeds
from avahazard.inference.likelihood.speed_nodes import squares
from avahazard.inference.likelihood.wrong_records import wrong_ranges
from avahazard.inference.model.friction_model import OffsetPlan
from avahazard.inference.model.observations import LEFT, SpeedRecord, speed_record
from avahazard.inference.prediction.stops import left_by_chance, look_up
from avahazard.physics.runout_curve import MU


@dataclass(frozen=True, slots=True, eq=False)
class BootstrapRecords:
    """What was measured of each event.

    `observed` (m), `left` `[n_events]`, and speeds of the events that have any.
    """

    observed: Floats
    left: NDArray[np.bool_]
    tracks: Tracks


def real_world(posterior: Posterior) -> BootstrapRecords:
    """The records themselves."""
    observations = posterior.observations
    left = observations.kind == LEFT
    observed = np.where(left, 0.0, observations.observed)
    return BootstrapRecords(observed, left, _tracks(observations.speeds))


def _tracks(records: Sequence[SpeedRecord]) -> Tracks:
    widest = max((len(m.x) for m in records), default=1)
    n_rows = max(1, len(records))
    speed, spread = np.zeros((n_rows, widest)), np.zeros((n_rows, widest, widest))
    places = np.zeros(n_rows, dtype=np.int64)
    for r, m in enumerate(records):
        k = len(m.x)
        places[r], speed[r, :k], spread[r, :k, :k] = k, m.speed, m.spread
    return Tracks(speed, places, spread)


def make_world(
    posterior: Posterior,
    predicted: Predicted,
    u: Floats,
    plan: OffsetPlan,
    tau: Floats,
    track_scatter: float,
    rng: np.random.Generator,
    broken: NDArray[np.bool_] | None = None,
    square: Sequence[Floats] | None = None,
) -> BootstrapRecords:
    """Records of the same events in a world where the model at u is true.

    Groups have offsets of spreads `tau` `[n_groupings]`; where a limit of sight stands, all
    events are seen. With Student's tails a record is wrong here as likely as it is
    in truth. `broken` as in `look_up`; `square` is u² of each track, `[n_friction, n_speeds]`.
    Both are found where they are not given.
    """
    observations = posterior.observations
    shift = plan.shift(tau[plan.of] * rng.standard_normal(len(plan.of)))
    if np.any(plan.alone):
        own = np.sqrt(np.sum(plan.alone * tau[:, None] ** 2, axis=0))
        shift = shift + own * rng.standard_normal(len(own))
    edge = hidden_from(observations, predicted, in_log=False)
    friction = draw_seen_friction(posterior, u, shift, edge, rng)
    observed, x, left = _record(predicted, friction, broken, rng)
    if square is None:
        square = [squares(table) for table in predicted.speeds]
    tracks = _tracks(
        [
            _measured(m, table, friction[m.event], x[m.event], track_scatter, rng)
            for m, table in zip(observations.speeds, square, strict=True)
        ]
    )
    if posterior.specification.tails == "student":
        low, high = wrong_ranges(observations)
        wrong = ~left & (rng.random(observations.n_events) < wrong_chance(posterior, u))
        observed = np.where(wrong, low + (high - low) * rng.random(observations.n_events), observed)
    return BootstrapRecords(observed, left, tracks)


def _measured(
    track: SpeedRecord,
    square: Floats,
    friction: float,
    stop_x: float,
    track_scatter: float,
    rng: np.random.Generator,
) -> SpeedRecord:
    """A track with this friction and stop, its speeds measured at the places that it came to.

    `square` `[n_friction, n_speeds]` is the block's u². What its friction made of it is tied to
    where it stopped, here as in the records.
    """
    k = int(np.searchsorted(track.x, stop_x))
    mine = at_friction(square[:, :k], friction)
    made = speed_record(
        track.event, track.x[:k], track.speed[:k], track.sigma[:k], track.release_x, stop_x
    )
    if k == 0:
        return made
    at_places = np.maximum(mine, 0.0)[:, None]
    speed = drawn_speeds(at_places, made, track_scatter, rng, arrives=True)[:, 0]
    return replace(made, speed=speed)


def at_friction(square: Floats, friction: float) -> Floats:
    """Columns `[n_friction, n]` over `MU` at one friction, straight between the nodes: `[n]`."""
    c = min(max(int(np.searchsorted(MU, friction, side="right")) - 1, 0), len(MU) - 2)
    slope = (square[c + 1] - square[c]) / (MU[c + 1] - MU[c])
    return np.asarray(square[c] + slope * (min(max(friction, MU[0]), MU[-1]) - MU[c]))


def wrong_chance(posterior: Posterior, u: Floats) -> Floats:
    """Chance of each record to be grossly wrong `[n_events]`, given the model at u."""
    return np.asarray(np.exp(posterior.log_wrong(u) - posterior.event_log_likelihood(u)))


def _record(
    predicted: Predicted,
    friction: Floats,
    broken: NDArray[np.bool_] | None,
    rng: np.random.Generator,
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Record, place x (without the record's error), and whether it left `[n_events]`."""
    record, x, _, left = look_up(predicted, friction[:, None], broken)
    left = left_by_chance(predicted, friction[:, None], left, rng, broken)
    error = predicted.sigma * rng.standard_normal(len(predicted.sigma))
    return record[:, 0] + error, x[:, 0], left[:, 0]
