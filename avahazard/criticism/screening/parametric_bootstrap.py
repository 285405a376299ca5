"""Worlds made from a fitted model on the user's own design: the parametric bootstrap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.speed_errors import drawn_speeds
from avahazard.inference.likelihood.speed_nodes import squares
from avahazard.inference.likelihood.wrong_records import wrong_ranges
from avahazard.inference.model.observations import LEFT
from avahazard.inference.model.offset_plan import OffsetPlan
from avahazard.inference.prediction.stops import draw_friction, look_up
from avahazard.physics.runout_curve import MU

MAX_REDRAWS = 200


@dataclass(frozen=True, slots=True, eq=False)
class BootstrapRecords:
    """What was measured of each event.

    `observed` (m), `left` `[n_events]`, and speeds `[n_rows, n_places]` of the events that have
    any.
    """

    observed: Floats
    left: NDArray[np.bool_]
    speeds: Floats


def real_world(posterior: Posterior) -> BootstrapRecords:
    """The records themselves."""
    observations = posterior.observations
    widest = max((len(m.x) for m in observations.speeds), default=1)
    speeds = np.zeros((max(1, len(observations.speeds)), widest))
    for r, m in enumerate(observations.speeds):
        speeds[r, : len(m.x)] = m.speed
    left = observations.kind == LEFT
    return BootstrapRecords(np.where(left, 0.0, observations.observed), left, speeds)


def make_world(
    posterior: Posterior,
    predicted: Predicted,
    u: Floats,
    plan: OffsetPlan,
    tau: Floats,
    track_scatter: float,
    rng: np.random.Generator,
    broken: NDArray[np.bool_] | None = None,
) -> BootstrapRecords:
    """Records of the same events in a world where the model at u is true.

    Groups have offsets of spreads `tau` `[n_groupings]`; where a limit of sight stands, events are
    drawn again until they are seen. With Student's tails a record is wrong here as likely as it is
    in truth. `broken` as in `look_up`.
    """
    observations = posterior.observations
    shift = plan.shift(tau[plan.of] * rng.standard_normal(len(plan.of)))
    if np.any(plan.alone):
        own = np.sqrt(np.sum(plan.alone * tau[:, None] ** 2, axis=0))
        shift = shift + own * rng.standard_normal(len(own))
    friction = draw_friction(posterior, u, shift, rng)
    observed, elevation, left = _record(predicted, friction, broken, rng)
    for _ in range(MAX_REDRAWS):
        hidden = ~left & (elevation > observations.limit)
        if not np.any(hidden):
            break
        again = draw_friction(posterior, u, shift, rng)
        friction = np.where(hidden, again, friction)
        fresh = _record(predicted, again, broken, rng)
        observed = np.where(hidden, fresh[0], observed)
        elevation = np.where(hidden, fresh[1], elevation)
        left = np.where(hidden, fresh[2], left)
    widest = max((len(m.x) for m in observations.speeds), default=1)
    speeds = np.zeros((max(1, len(observations.speeds)), widest))
    for r, (m, table) in enumerate(zip(observations.speeds, predicted.speeds, strict=True)):
        square = [np.interp(friction[m.event], MU, column) for column in squares(table).T]
        at_rest = np.maximum(square, 0.0)[:, None]
        speeds[r, : len(m.x)] = drawn_speeds(at_rest, m, track_scatter, rng, arrives=False)[:, 0]
    if posterior.specification.tails == "student":
        low, high = wrong_ranges(observations)
        wrong = ~left & (rng.random(observations.n_events) < wrong_chance(posterior, u))
        observed = np.where(wrong, low + (high - low) * rng.random(observations.n_events), observed)
    return BootstrapRecords(observed, left, speeds)


def wrong_chance(posterior: Posterior, u: Floats) -> Floats:
    """Chance of each record to be grossly wrong `[n_events]`, given the model at u."""
    return np.asarray(np.exp(posterior.log_wrong(u) - posterior.event_log_likelihood(u)))


def _record(
    predicted: Predicted,
    friction: Floats,
    broken: NDArray[np.bool_] | None,
    rng: np.random.Generator,
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    record, _, elevation, left = look_up(predicted, friction[:, None], broken)
    error = predicted.sigma * rng.standard_normal(len(predicted.sigma))
    return record[:, 0] + error, elevation[:, 0] + error, left[:, 0]
