"""Posteriors of extreme-value distributions over a grid of scale and shape.

Few parameters and few data: a grid needs no chains and no convergence. The likelihood of other
paths serves as a prior where a path has too few records of its own.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from scipy.special import gamma, logsumexp

from avahazard.arrays import Floats
from avahazard.hazard.frequency_draws import Gev
from avahazard.inference.likelihood.density_sums import exp_memory, exponentials, logarithms
from avahazard.kernels import kernel

LOG_SCALES = np.array([-2.6 + 0.07 * k for k in range(61)])
"""Grid of the log of the scale, `[n_scales]`."""
SHAPES = np.array([-0.475 + 0.05 * k for k in range(27)])
"""Grid of the shape in the sign of `scipy.stats.genextreme`, `[n_shapes]`: positive has an upper
bound. Nought is between two of its points."""
MEAN_OFFSET = (1.0 - gamma(1.0 + SHAPES)) / SHAPES
"""Mean less location of a GEV, in scales, `[n_shapes]`."""
STANDARD_DEVIATION = np.sqrt(gamma(1.0 + 2.0 * SHAPES) - gamma(1.0 + SHAPES) ** 2) / np.abs(SHAPES)
"""Of a GEV, in scales, `[n_shapes]`."""
DEVIATIONS = np.linspace(-5.0, 5.0, 33)
"""Grid of the mean about the sample's, in standard errors, `[n_locations]`."""
LEAST_INSIDE = 1e-300
"""Stands for what is 0 or less, where a maximum is impossible, until all is summed."""
SPREAD = 1.3
"""Standard deviation of a GEV near shape 0, in scales."""
SHAPE_CENTRE, SHAPE_SD = 0.2, 0.15
"""Weak prior of the shape, normal. Lognormal volumes have logs of shape near 0.28, volumes with a
Pareto tail 0; a bound by the snow of the release zone is a larger shape."""
BETWEEN_SCALE, BETWEEN_SHAPE = 0.2, 0.1
"""How far paths of one region differ in log scale and in shape (standard deviations)."""


def shape_prior(centre: float = SHAPE_CENTRE, sd: float = SHAPE_SD, error: float = 0.0) -> Floats:
    """Log prior density `[n_scales, n_shapes]`: flat in log scale, normal in the shape.

    Where records have an `error` (sd), it is flat in the log of the scale with which they spread:
    flat in that of what lies under it, it would let the error be all there is.
    """
    row: Floats = -0.5 * ((SHAPES - centre) / sd) ** 2
    return np.asarray(row + 2.0 * (LOG_SCALES[:, None] - with_error(error)))


def with_error(error: float) -> Floats:
    """Log scale `[n_scales, n_shapes]` with which records spread whose errors have this sd."""
    square = np.exp(2.0 * LOG_SCALES)[:, None] + (error / STANDARD_DEVIATION) ** 2
    return np.asarray(0.5 * np.log(square))


def regional_prior(others: Floats, error: float = 0.0) -> Floats:
    """Log prior `[n_scales, n_shapes]` of a path in the light of other paths.

    `others` is the sum of their log likelihoods over the grid. Their common scale and shape are
    known from all together; the path's own differ from these by `BETWEEN_SCALE` and
    `BETWEEN_SHAPE`. `error` as in `shape_prior`.
    """
    together = shape_prior(error=error) + others
    density = np.exp(together - logsumexp(together))
    steps = (BETWEEN_SCALE / np.diff(LOG_SCALES)[0], BETWEEN_SHAPE / np.diff(SHAPES)[0])
    blurred = gaussian_filter(density, steps, mode="nearest")
    return np.asarray(np.log(np.maximum(blurred, 1e-300)))


def gev_likelihood(sample: Floats, least: float = -np.inf, error: float = 0.0) -> Floats:
    """Log likelihood `[n_scales, n_shapes, n_locations]` of maxima `[n]` recorded with an `error`.

    With normal errors of that sd they are taken for a GEV of the same mean and shape that spreads
    by both (`with_error`). It is -inf where it is under `least`.
    """
    centred = sample - sample.mean()
    grids = (with_error(error), SHAPES, _locations(len(sample)))
    return np.asarray(_gev_likelihood(centred, *grids, least))


@kernel
def _gev_likelihood(centred, log_scales, shapes, locations, least):  # type: ignore[no-untyped-def]
    n, n_locations = len(centred), locations.shape[1]
    result = np.full((len(log_scales), len(shapes), n_locations), -np.inf)
    inside, smallest = np.empty(n * n_locations), np.empty(n_locations)
    bits, memory = inside.view(np.int64), exp_memory(n * n_locations)
    for i in range(len(log_scales)):
        for k in range(len(shapes)):
            shape, total = shapes[k], result[i, k]
            scaled = centred * math.exp(-log_scales[i, k])
            # A flat prior of the location in log m3 is one of the grid's times the scale.
            total[:] = -(n - 1) * log_scales[i, k]
            smallest[:] = np.inf
            for j in range(n):
                row = inside[j * n_locations : (j + 1) * n_locations]
                for m in range(n_locations):
                    value = 1.0 - shape * (scaled[j] - locations[k, m])
                    smallest[m] = min(smallest[m], value)
                    row[m] = max(value, LEAST_INSIDE)
            if np.max(smallest) <= 0.0:
                total[:] = -np.inf
                continue
            # log, then exp, of all at once.
            logarithms(inside, bits, len(inside), memory)
            for j in range(n):
                row = inside[j * n_locations : (j + 1) * n_locations]
                for m in range(n_locations):
                    total[m] += (1.0 / shape - 1.0) * row[m]
                    row[m] = min(row[m] / shape, 700.0)
            exponentials(inside, len(inside), memory)
            for j in range(n):
                row = inside[j * n_locations : (j + 1) * n_locations]
                for m in range(n_locations):
                    total[m] -= row[m]
            for m in range(n_locations):
                if smallest[m] <= 0.0 or total[m] < least:
                    total[m] = -np.inf
    return result


def gev_draws(
    sample: Floats,
    prior: Floats,
    likelihood: Floats,
    n: int,
    rng: np.random.Generator,
    *,
    error: float = 0.0,
    middle: float | None = None,
) -> Gev:
    """Draws `[n]` of the GEV of true maxima, from the `gev_likelihood` of `sample` and a log prior.

    `sample` `[n_maxima]` was recorded with `error`. The largest record of a year owes it to its
    error too: the draws lie nearer to `middle`, the mean of all records, by as much as these
    spread more than true ones.
    """
    i, k, m = _cells(likelihood + prior[:, :, None], n, rng)
    scale = np.exp(_spread(LOG_SCALES, i, rng))
    wider = np.exp(with_error(error)[i, k] - LOG_SCALES[i])
    grid = _locations(len(sample))
    step = (grid[0, 1] - grid[0, 0]) * rng.uniform(-0.5, 0.5, n)
    centre = sample.mean()
    if middle is not None:
        centre = centre - (1.0 - 1.0 / wider) * (centre - middle)
    # The mean stays; the location is that of a smaller scale.
    place = (grid[k, m] + step) * wider + (wider - 1.0) * MEAN_OFFSET[k]
    return Gev(_spread(SHAPES, k, rng), centre + place * scale, scale)


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
    return np.asarray(_over_locations(likelihood))


@kernel
def _over_locations(likelihood):  # type: ignore[no-untyped-def]
    n_scales, n_shapes, n_locations = likelihood.shape
    result = np.full((n_scales, n_shapes), -np.inf)
    part, memory = np.empty(n_locations), exp_memory(n_locations)
    for i in range(n_scales):
        for k in range(n_shapes):
            largest = np.max(likelihood[i, k])
            if largest > -np.inf:
                part[:] = likelihood[i, k] - largest
                exponentials(part, n_locations, memory)
                result[i, k] = largest + math.log(np.sum(part))
    return result


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
