"""The likelihood of one record by brute integration over friction."""

from __future__ import annotations

import numpy as np
from scipy import stats

from avahazard.inference.likelihood.track_nodes import squared
from avahazard.inference.model.observations import SpeedRecord

PER_CELL = 60


def fine(grid: np.ndarray, per_cell: int = PER_CELL) -> tuple[np.ndarray, np.ndarray]:
    """Midpoints of every cell cut into `per_cell` parts, and the width of each part."""
    t = (np.arange(per_cell) + 0.5) / per_cell
    width = np.diff(grid)
    return ((grid[:-1, None] + width[:, None] * t).ravel(), np.repeat(width / per_cell, per_cell))


def likelihood(
    record,
    left,
    observed,
    sigma,
    grid,
    scatter_density,
    log_speed=None,
    per_cell=PER_CELL,
    limit=np.inf,
):
    """∫ N(y | F(μ), σ) p(speeds | μ) p(ν) dν, F linear between the frictions of the grid.

    Over stops up to the `limit` alone.
    """
    nu, width = fine(grid, per_cell)
    f = np.interp(nu, grid, record)
    both_left = np.repeat(left[:-1] & left[1:], per_cell)
    density = np.where(both_left | (f > limit), 0.0, stats.norm.pdf(observed, f, sigma))
    if log_speed is not None:
        density = density * np.exp(np.interp(nu, grid, log_speed))
    return float(np.sum(width * density * scatter_density(nu)))


def leaving(left, grid, scatter_density, log_speed=None):
    """∫ over the frictions that run beyond the profile; it changes midway between frictions."""
    nu, width = fine(grid)
    nearest = np.clip(np.searchsorted(0.5 * (grid[1:] + grid[:-1]), nu), 0, len(grid) - 1)
    density = left[nearest] * scatter_density(nu)
    if log_speed is not None:
        density = density * np.exp(np.interp(nu, grid, log_speed))
    return float(np.sum(width * density))


def seen(elevation, left, limit, grid, scatter_density):
    """Chance of a stop at the `limit` or below, what left among them."""
    nu, width = fine(grid)
    both_left = np.repeat(left[:-1] & left[1:], PER_CELL)
    below = both_left | (np.interp(nu, grid, elevation) <= limit)
    return float(np.sum(width * below * scatter_density(nu)))


def recorded(elevation, left, limit, sigma, grid, scatter_density):
    """Chance that a record below `limit` is made, with all beyond the profile."""
    nu, width = fine(grid)
    chance = np.where(left, 1.0, stats.norm.cdf((limit - elevation) / sigma))
    return float(np.sum(width * np.interp(nu, grid, chance) * scatter_density(nu)))


def speed_log_likelihood(track: SpeedRecord, predicted: np.ndarray, scatter: float) -> np.ndarray:
    """Log density of the speeds of one track, `[n]`, by the law of their squares.

    `predicted` `[n, n_speeds]` in m/s, `scatter` of friction along the track.
    """
    square, error = squared(track.speed, track.sigma)
    law = stats.multivariate_normal(square, scatter**2 * track.spread + np.diag(error**2))
    return np.atleast_1d(law.logpdf(predicted**2)) + np.sum(np.log(error / track.sigma))
