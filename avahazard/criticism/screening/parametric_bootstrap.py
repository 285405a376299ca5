"""Datasets simulated from a fitted model on the user's own design: the parametric bootstrap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, ndtri_exp, stdtr, stdtrit

from avahazard.arrays import Floats
from avahazard.criticism.screening.speed_points import Tracks
from avahazard.inference.likelihood.nodes import wrong_ranges
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.record_nodes import hidden_from
from avahazard.inference.likelihood.track_nodes import drawn_speeds, squares
from avahazard.inference.model.friction_model import OffsetPlan
from avahazard.inference.model.friction_scatter import DEGREES, friction
from avahazard.inference.model.layout import Slot
from avahazard.inference.model.observations import LEFT, SpeedRecord, speed_record
from avahazard.inference.prediction import (
    draw_friction,
    law_at_drawn_volumes,
    left_by_chance,
    look_up,
)
from avahazard.physics.runout_curve import MU

MAX_REDRAWS = 200
N_POINTS = 40
N_DRAWS = 400


@dataclass(frozen=True, slots=True, eq=False)
class BootstrapRecords:
    """What was measured of each event.

    `observed` (m), `left` `[n_events]`, and speeds of the events that have any.
    """

    observed: Floats
    left: NDArray[np.bool_]
    tracks: Tracks


def actual_records(posterior: Posterior) -> BootstrapRecords:
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


def simulate(
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
    """Records of the same events in a dataset where the model at u is true.

    Groups have offsets of spreads `tau` `[n_groupings]`; where a detection limit stands, all
    events are detected. With Student's tails a record is wrong here as likely as it is
    in truth. `broken` as in `look_up`; `square` is u² of each track, `[n_friction, n_speeds]`.
    Both are found where they are not given.
    """
    observations = posterior.observations
    shift = plan.shift(tau[plan.of] * rng.standard_normal(len(plan.of)))
    if np.any(plan.alone):
        own = np.sqrt(np.sum(plan.alone * tau[:, None] ** 2, axis=0))
        shift = shift + own * rng.standard_normal(len(own))
    edge = hidden_from(observations, predicted, in_log=False)
    friction = draw_detected_friction(posterior, u, shift, edge, rng)
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


def draw_detected_friction(
    posterior: Posterior, u: Floats, shift: Floats, edge: Floats, rng: np.random.Generator
) -> Floats:
    """One draw of μ `[n_events]`, none above `edge` `[n_events]` (μ), where no stop is detected.

    Arguments else as in `draw_friction`. What is above is drawn again. Where a path's offset leaves
    hardly a stop to be detected, that would find none: there the scatter is drawn below the edge at
    once, at a volume that was drawn as if it were of no account.
    """
    drawn = draw_friction(posterior, u, shift, rng)
    for _ in range(MAX_REDRAWS):
        hidden = drawn > edge
        if not np.any(hidden):
            return drawn
        drawn = np.where(hidden, draw_friction(posterior, u, shift, rng), drawn)
    in_log = posterior.layout.log_scatter
    location, scatter = law_at_drawn_volumes(posterior, u, shift, rng)
    with np.errstate(invalid="ignore"):
        highest = ((np.log(edge) if in_log else edge) - location) / scatter
    z = draw_below(highest, posterior.specification.tails == "student", rng)
    below = np.minimum(friction(location, scatter * z, in_log), edge)
    return np.where(drawn > edge, below, drawn)


def draw_below(highest: Floats, student: bool, rng: np.random.Generator) -> Floats:
    """Draws of z `[n]`, none over `highest` `[n]`, good far into the lower tail."""
    share = 1.0 - rng.random(len(highest))
    if student:
        return np.asarray(stdtrit(DEGREES, share * stdtr(DEGREES, highest)))
    return np.asarray(ndtri_exp(log_ndtr(highest) + np.log(share)))


@dataclass(frozen=True, slots=True, eq=False)
class GroupSpreads:
    """The groupings that a model grants, and the spreads τ of their offsets.

    `tau` `[n_groupings]` at the mode; `draws` `[n_draws, n_groupings]` of their posterior, since
    few groups hardly tell it: datasets made with the mode alone would hold too little of what
    groups may differ by. `scale` `[n_groupings]` is that of their half-normal priors, or of one as
    wide as a prior that was given.
    """

    plan: OffsetPlan
    tau: Floats
    draws: Floats
    scale: Floats

    def drawn(self, rng: np.random.Generator) -> Floats:
        """Spreads `[n_groupings]` of one simulated dataset."""
        return np.array([rng.choice(column) for column in self.draws.T])


def group_spreads(posterior: Posterior, u: Floats) -> GroupSpreads:
    """The spreads of a model at its mode u; each is drawn given the other coordinates."""
    layout = posterior.layout
    slots = list(layout.spreads.values())
    columns = [_draws(posterior, u, k) * layout.slots[k].scale for k in slots]
    return GroupSpreads(
        posterior.plan,
        layout.spread_values(u),
        np.column_stack(columns) if columns else np.empty((N_DRAWS, 0)),
        np.array([scale_of(layout.slots[k]) for k in slots]),
    )


def scale_of(slot: Slot) -> float:
    """Root mean square of a spread before any record: of its half-normal prior, the scale."""
    mean_square = math.exp(2.0 * (slot.mean + slot.sd**2)) if slot.lognormal else 1.0
    return slot.scale * math.sqrt(mean_square)


def _draws(posterior: Posterior, u: Floats, k: int) -> Floats:
    """Evenly spaced quantiles `[n_draws]` of coordinate k given the others."""
    slot = posterior.layout.slots[k]
    points = np.geomspace(max(slot.low, 0.02), min(slot.high, 5.0), N_POINTS)
    at = np.tile(u, (N_POINTS, 1))
    at[:, k] = points
    log_density = posterior.log_densities(at)
    density = np.exp(log_density - np.max(log_density))
    level = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(points) * (density[1:] + density[:-1]))])
    even = (np.arange(N_DRAWS) + 0.5) / N_DRAWS
    return np.asarray(np.interp(even * level[-1], level, points))
