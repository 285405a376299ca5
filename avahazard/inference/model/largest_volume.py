"""The largest volume that there is: release zones are full at some time."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.special import log_ndtr

from avahazard.arrays import Floats, Ints
from avahazard.inference.model.friction_scatter import HALF_LOG_2PI

TRIED = np.linspace(0.8, 1.0, 9)
"""Quantiles of the records at which a largest volume is tried; beyond, some of its distance."""
STEPS, CLOSE = 200, 1e-6
WIDEST = 5.0
"""Times the spread of what is recorded that normals have at most."""
MOST_PULL = 2.0
"""Spreads by which the centre of a path whose records crowd at the end is put above their mean."""


class CutNormals(NamedTuple):
    """Normals about `centre` `[n_paths]` of standard deviation `spread`, all cut at `largest`."""

    centre: Floats
    spread: float
    largest: float


def cut_normals(centre: Floats, count: Ints, spread: float, largest: float) -> CutNormals:
    """Normals that have these means and, on the mean of `count` `[n_paths]`, this spread when cut.

    As near as can be: what is cut above is no more skewed than an exponential.
    """
    c, s = centre, spread
    if np.isinf(largest):
        return CutNormals(c, s, largest)
    for _ in range(STEPS):
        z = (largest - c) / s
        pull = np.minimum(np.exp(-0.5 * z**2 - HALF_LOG_2PI - log_ndtr(z)), MOST_PULL)
        share = np.average(1.0 - z * pull - pull**2, weights=count)
        before, c = s, centre + s * pull
        s = spread / np.sqrt(max(share, WIDEST**-2))
        if abs(s - before) < CLOSE * s:
            break
    return CutNormals(c, s, largest)


def largest_volume(
    recorded: Floats, sigma: Floats, path: Ints, centre: Floats, spread: float
) -> tuple[float, float]:
    """The likeliest largest log volume, and its log likelihood ratio over none (nats).

    Given log records `[n]`, their errors, the `path` `[n]` of each, and the `centre` `[n_paths]`
    and `spread` of what is recorded, less its errors. The ratio is less half the log of the number
    of records, which is what a parameter costs.
    """
    from scipy.optimize import minimize_scalar  # noqa: PLC0415 (slow to import)

    count = np.bincount(path, minlength=len(centre))
    told = partial(_log_likelihood, recorded, sigma, path, count, centre, spread)
    beyond = recorded.max() + spread * np.array([0.25, 0.5, 1.0, 2.0])
    tried = np.concatenate([np.quantile(recorded, TRIED), beyond])
    found = np.array([told(largest) for largest in tried])
    best = int(np.argmax(found))
    near = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
    finer = minimize_scalar(lambda v: -told(v), bounds=near, method="bounded")
    largest = float(finer.x if -finer.fun > found[best] else tried[best])
    return largest, float(max(-finer.fun, found[best]) - told(np.inf) - 0.5 * np.log(len(recorded)))


def _log_likelihood(
    recorded: Floats,
    sigma: Floats,
    path: Ints,
    count: Ints,
    centre: Floats,
    spread: float,
    largest: float,
) -> float:
    """Log likelihood of the records where no true volume is over the `largest` (log)."""
    cut = cut_normals(centre, count, spread, largest)
    middle, total2 = cut.centre[path], cut.spread**2 + sigma**2
    away = recorded - middle
    mean = middle + away * cut.spread**2 / total2
    sd = np.maximum(cut.spread * sigma / np.sqrt(total2), 1e-9)
    seen = log_ndtr((largest - mean) / sd) - log_ndtr((largest - middle) / cut.spread)
    return float(np.sum(seen - 0.5 * (np.log(total2) + away**2 / total2)))
