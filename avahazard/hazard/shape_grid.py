"""Posteriors of extreme-value distributions over a grid of scale and shape.

Few parameters and few data: a grid needs no chains and no convergence. The likelihood of other
paths serves as a prior where a path has too few records of its own.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from scipy.special import gamma, logsumexp

from avahazard.hazard.gev import Gev

Floats = NDArray[np.float64]

LOG_SCALES = np.array([-2.6 + 0.07 * k for k in range(61)])
"""Grid of the log of the scale, `[n_scales]`."""
SHAPES = np.array([-0.475 + 0.05 * k for k in range(27)])
"""Grid of the shape in the sign of `scipy.stats.genextreme`, `[n_shapes]`: positive has an upper
bound. Nought is between two of its points."""
MEAN_OFFSET = (1.0 - gamma(1.0 + SHAPES)) / SHAPES
"""Mean less location of a GEV, in scales, `[n_shapes]`."""
DEVIATIONS = np.linspace(-5.0, 5.0, 33)
"""Grid of the mean about the sample's, in standard errors, `[n_locations]`."""
SPREAD = 1.3
"""Standard deviation of a GEV near shape 0, in scales."""
SHAPE_CENTRE, SHAPE_SD = 0.2, 0.15
"""Weak prior of the shape, normal. Lognormal volumes have logs of shape near 0.28, volumes with a
Pareto tail 0; a bound by the snow of the release zone is a larger shape."""
BETWEEN_SCALE, BETWEEN_SHAPE = 0.2, 0.1
"""How far paths of one region differ in log scale and in shape (standard deviations)."""


def shape_prior(centre: float = SHAPE_CENTRE, sd: float = SHAPE_SD) -> Floats:
    """Log prior density `[n_scales, n_shapes]`: flat in log scale, normal in the shape."""
    row: Floats = -0.5 * ((SHAPES - centre) / sd) ** 2
    return np.asarray(row + np.zeros((len(LOG_SCALES), 1)))


def regional_prior(likelihoods: Sequence[Floats]) -> Floats:
    """Log prior `[n_scales, n_shapes]` of a path in the light of other paths.

    `likelihoods` are their log likelihoods over the grid. Their common scale and shape are known
    from all together; the path's own differ from these by `BETWEEN_SCALE` and `BETWEEN_SHAPE`.
    """
    together = shape_prior() + np.sum(likelihoods, axis=0)
    density = np.exp(together - logsumexp(together))
    steps = (BETWEEN_SCALE / np.diff(LOG_SCALES)[0], BETWEEN_SHAPE / np.diff(SHAPES)[0])
    blurred = gaussian_filter(density, steps, mode="nearest")
    return np.asarray(np.log(np.maximum(blurred, 1e-300)))


def gev_likelihood(sample: Floats) -> Floats:
    """Log likelihood `[n_scales, n_shapes, n_locations]` of maxima `[n]`."""
    scale = np.exp(LOG_SCALES)[:, None, None]
    centred = (sample - sample.mean()) / scale
    result = np.empty((len(LOG_SCALES), len(SHAPES), len(DEVIATIONS)))
    for k, shape in enumerate(SHAPES):
        inside = 1.0 - shape * (centred - _locations(len(sample))[k][:, None])
        possible = (inside > 0.0).all(axis=-1)
        log_inside = np.log(np.where(inside > 0.0, inside, 1.0))
        density = (1.0 / shape - 1.0) * log_inside - np.exp(np.minimum(log_inside / shape, 700.0))
        total = density.sum(axis=-1) - len(sample) * LOG_SCALES[:, None]
        result[:, k] = np.where(possible, total, -np.inf)
    # A flat prior of the location in log m3 is one of the grid's times the scale.
    return np.asarray(result + LOG_SCALES[:, None, None])


def gev_draws(
    sample: Floats, prior: Floats, likelihood: Floats, n: int, rng: np.random.Generator
) -> Gev:
    """Draws `[n]` of the GEV of maxima `[n_maxima]`, from `gev_likelihood` and a log prior."""
    i, k, m = _cells(likelihood + prior[:, :, None], n, rng)
    scale = np.exp(_spread(LOG_SCALES, i, rng))
    grid = _locations(len(sample))
    step = (grid[0, 1] - grid[0, 0]) * rng.uniform(-0.5, 0.5, n)
    return Gev(_spread(SHAPES, k, rng), sample.mean() + (grid[k, m] + step) * scale, scale)


def gpd_likelihood(excess: Floats) -> Floats:
    """Log likelihood `[n_scales, n_shapes]` of excesses `[n]` over a threshold."""
    scaled = excess / np.exp(LOG_SCALES)[:, None, None]
    inside = 1.0 - SHAPES[:, None] * scaled
    possible = (inside > 0.0).all(axis=-1)
    log_inside = np.log(np.where(inside > 0.0, inside, 1.0))
    total = ((1.0 / SHAPES[:, None] - 1.0) * log_inside).sum(axis=-1)
    return np.where(possible, total - len(excess) * LOG_SCALES[:, None], -np.inf)


def gpd_draws(
    prior: Floats, likelihood: Floats, n: int, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Draws `[n]` of scale and shape (sign as `SHAPES`) of the excesses."""
    i, k = _cells(likelihood + prior, n, rng)
    return np.exp(_spread(LOG_SCALES, i, rng)), _spread(SHAPES, k, rng)


def over_locations(likelihood: Floats) -> Floats:
    """The log likelihood of scale and shape alone `[n_scales, n_shapes]`."""
    with np.errstate(divide="ignore"):
        return np.asarray(logsumexp(likelihood, axis=2))


def _locations(n: int) -> Floats:
    """Location less the mean of a sample of n, in scales, `[n_shapes, n_locations]`."""
    return np.asarray(DEVIATIONS * SPREAD / np.sqrt(n) - MEAN_OFFSET[:, None])


def _cells(log_density: Floats, n: int, rng: np.random.Generator) -> tuple[NDArray[np.int64], ...]:
    """Grid indices of draws, an array `[n]` for each axis."""
    flat = log_density.ravel()
    weight = np.exp(flat - flat.max())
    drawn = rng.choice(len(flat), size=n, p=weight / weight.sum())
    return tuple(np.asarray(axis) for axis in np.unravel_index(drawn, log_density.shape))


def _spread(grid: Floats, index: NDArray[np.int64], rng: np.random.Generator) -> Floats:
    """Values about the points of a uniform grid, within half a step."""
    return np.asarray(grid[index] + (grid[1] - grid[0]) * rng.uniform(-0.5, 0.5, len(index)))
