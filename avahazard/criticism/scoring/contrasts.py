"""Whether the events of a level differ from the others, where paths may differ too.

z = a + d x + b(path) + e, with x = 1 in the level: d is found from the events within paths and
from the means of paths, each weighted by what it knows. A level that is the same on a whole path
is told by the means alone, one that varies within paths hardly needs them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.criticism.scoring.axes import Levels


def contrast_p_values(z: Floats, levels: Levels, path: NDArray[np.int64]) -> dict[str, float]:
    """p-value of every level against the other events.

    Empty where each lies on one path only: then nothing can be said beyond the paths. Arguments are
    `[n_events]`, z of unit variance.
    """
    names = np.unique(levels)
    cells = np.unique(np.column_stack([np.searchsorted(names, levels), path]), axis=0)
    if len(cells) == len(names):
        return {}
    _, path = np.unique(path, return_inverse=True)
    tested = {str(name): contrast_p(z, (levels == name).astype(float), path) for name in names}
    return {name: p for name, p in tested.items() if p is not None}


def contrast_p(z: Floats, x: Floats, path: NDArray[np.int64]) -> float | None:
    """Two-sided p-value of d = 0 by t; None where the data do not hold it.

    Variances within and between paths are by moments; the degrees of freedom are those of the
    two estimates of d combined.
    """
    from scipy.special import stdtr  # noqa: PLC0415 (slow)

    count = np.bincount(path)
    x_mean, z_mean = np.bincount(path, x) / count, np.bincount(path, z) / count
    x_in, z_in = x - x_mean[path], z - z_mean[path]
    squares = float(np.sum(x_in**2))
    varies = squares > 1e-9 * len(x)
    slope = float(np.sum(x_in * z_in)) / squares if varies else 0.0
    free_within = len(z) - len(count) - int(varies)
    within = 1.0
    if free_within > 0:
        # Ranks of a right model have variance one; less is chance.
        within = max(1.0, float(np.sum((z_in - slope * x_in) ** 2)) / free_within)
    free_between, between = _between(x_mean, z_mean, count, within)
    weight = 1.0 / (within / count + between)
    ahead = x_mean - np.sum(weight * x_mean) / np.sum(weight)
    known_within = squares / within if varies and free_within > 0 else 0.0
    known_between = float(np.sum(weight * ahead**2)) if free_between > 0 else 0.0
    known = known_within + known_between
    if known <= 1e-9:
        return None
    part = slope * known_within
    if known_between > 0.0:
        part += float(np.sum(weight * ahead * z_mean))
    uncertain = 0.0
    if known_within > 0.0:
        uncertain += (known_within / known) ** 2 / free_within
    if known_between > 0.0:
        uncertain += (known_between / known) ** 2 / free_between
    return float(2.0 * stdtr(1.0 / uncertain, -abs(part) / np.sqrt(known)))


def _between(
    x_mean: Floats, z_mean: Floats, count: NDArray[np.int64], within: float
) -> tuple[int, float]:
    """Degrees of freedom and variance of the offsets of paths, about a line in their mean x."""
    columns = [np.ones(len(count))]
    if np.ptp(x_mean) > 1e-9:
        columns.append(x_mean)
    design = np.column_stack(columns)
    free = len(count) - design.shape[1]
    if free < 1:
        return 0, 0.0
    inverse = np.linalg.inv(design.T @ (count[:, None] * design))
    line = design @ (inverse @ (design.T @ (count * z_mean)))
    squares = float(np.sum(count * (z_mean - line) ** 2))
    expected = np.sum(count) - np.trace(inverse @ (design.T @ (count[:, None] ** 2.0 * design)))
    return free, max(0.0, (squares - free * within) / float(expected))
