"""The yearly rate of avalanches with friction under μ, as curves for fast reading."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.avalanches import Avalanches, friction_below
from avahazard.physics.runout_curve import MU

N_NODES = 128
REACH, STUDENT_REACH = 6.0, 16.0
"""How far the curves go, in scatters from the location: beyond is under 1e-5 of avalanches."""
LEAST_WIDTH = 1e-8
LEAST_RATE = 1e-30


@dataclass(frozen=True, slots=True, eq=False)
class RateCurves:
    """Log yearly rate `[n_parameters, n_classes, N_NODES]` of avalanches with friction under μ.

    Node k lies at log μ = `low` + k `step`, both `[n_parameters, n_classes]`; below the first node
    the rate is nought, above the last it is that of the last.
    """

    low: Floats
    step: Floats
    log_rate: Floats


def rate_curves(avalanches: Avalanches) -> RateCurves:
    """Tabulate the rates of each posterior draw and class, where their frictions lie.

    The range is cut to the frictions that the block is run for.
    """
    if avalanches.n_classes > 1 and _alike(avalanches.location) and _alike(avalanches.scatter):
        # Classes that differ by their release alone share their friction.
        first = replace(
            avalanches,
            location=avalanches.location[:, :1],
            scatter=avalanches.scatter[:, :1],
            class_share=np.ones(1),
        )
        one = rate_curves(first)
        shares = np.log(avalanches.class_share)[:, None]
        n = avalanches.n_classes
        return RateCurves(
            np.repeat(one.low, n, axis=1), np.repeat(one.step, n, axis=1), one.log_rate + shares
        )
    reach = STUDENT_REACH if avalanches.student else REACH
    low = np.min(avalanches.location - reach * avalanches.scatter, axis=2)
    high = np.max(avalanches.location + reach * avalanches.scatter, axis=2)
    if not avalanches.in_log:
        low, high = np.log(np.maximum(low, MU[0])), np.log(np.maximum(high, MU[0]))
    low = np.clip(low - LEAST_WIDTH, np.log(MU[0]), np.log(MU[-1]))
    high = np.maximum(np.minimum(high + LEAST_WIDTH, np.log(MU[-1])), low + LEAST_WIDTH)
    step = (high - low) / (N_NODES - 1)
    rates = np.empty((*low.shape, N_NODES))
    for k in range(N_NODES):
        chance = friction_below(avalanches, np.exp(low + k * step))
        rates[:, :, k] = np.einsum("pcv,pv->pc", chance, avalanches.volumes.share)
    rates *= avalanches.volumes.rate[:, None, None] * avalanches.class_share[:, None]
    return RateCurves(low, step, np.log(np.maximum(rates, LEAST_RATE)))


def _alike(values: Floats) -> bool:
    """Whether all classes of `[n_parameters, n_classes, n_volumes]` have the same."""
    return bool(np.array_equal(values, np.broadcast_to(values[:, :1], values.shape)))
