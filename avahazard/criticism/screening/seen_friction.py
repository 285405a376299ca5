"""Friction of made avalanches whose stops are seen."""

from __future__ import annotations

import numpy as np
from scipy.special import log_ndtr, ndtri_exp, stdtr, stdtrit

from avahazard.arrays import Floats
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_scatter import DEGREES, friction
from avahazard.inference.prediction.stops import draw_friction, law_at_drawn_volumes

MAX_REDRAWS = 200


def draw_seen_friction(
    posterior: Posterior, u: Floats, shift: Floats, edge: Floats, rng: np.random.Generator
) -> Floats:
    """One draw of μ `[n_events]`, none above `edge` `[n_events]` (μ), from which on none is seen.

    Arguments else as in `draw_friction`. What is above is drawn again. Where a path's offset leaves
    hardly a stop to be seen, that would find none: there the scatter is drawn below the edge at
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
