"""How much groups of events differ, as far as the records tell: the spreads of their offsets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_model import OffsetPlan
from avahazard.inference.model.layout import Slot

N_POINTS = 40
N_DRAWS = 400


@dataclass(frozen=True, slots=True, eq=False)
class GroupSpreads:
    """The groupings that a model grants, and the spreads τ of their offsets.

    `tau` `[n_groupings]` at the mode; `draws` `[n_draws, n_groupings]` of their posterior, since
    few groups hardly tell it: worlds made with the mode alone would hold too little of what groups
    may differ by. `scale` `[n_groupings]` is that of their half-normal priors,
    or of one as wide as a prior that was given.
    """

    plan: OffsetPlan
    tau: Floats
    draws: Floats
    scale: Floats

    def drawn(self, rng: np.random.Generator) -> Floats:
        """Spreads `[n_groupings]` of one made world."""
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
