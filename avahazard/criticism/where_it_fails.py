"""Where a model fails: its bias along every axis, and whether chance could do that."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.axes import Levels

Floats = NDArray[np.float64]

MIN_EVENTS = 5
MIN_PATHS = 5
PIT_EDGE = 1e-6


def where_it_fails(
    axes: Mapping[str, Levels], error: Floats, pit: Floats, path: NDArray[np.int64]
) -> list[dict[str, Any]]:
    """Rows `{"axis", "level", "n", "bias_m", "p_value"}` of `compare`, the least likely first.

    `error` `[n_events]` is predicted mean less record (m), `pit` the rank of the record in its
    predictive distribution, `path` the index of each event's path. The p-value is that of the
    mean of Φ⁻¹(PIT) in a level (two-sided). Events of one path are not independent: with five
    paths or more, axes other than the path allow for a spread between paths. Values are corrected
    for the number of axes and levels (Holm 1979). Levels of fewer than five events are left out.
    """
    from scipy.special import ndtri  # noqa: PLC0415 (slow)

    z = ndtri(np.clip(pit, PIT_EDGE, 1.0 - PIT_EDGE))
    clustered = len(np.unique(path[path >= 0])) >= MIN_PATHS
    rows: list[dict[str, Any]] = []
    for axis, levels in axes.items():
        known = levels != ""
        names, counts = np.unique(levels[known], return_counts=True)
        if len(names) < 2:
            continue
        if clustered and axis != "path":
            p_of = _clustered_p_values(z[known], levels[known], path[known])
        else:
            p_of = {str(name): _normal_p(z[levels == name]) for name in names}
        for name, n in zip(names, counts, strict=True):
            if n >= MIN_EVENTS and str(name) in p_of:
                bias = float(np.mean(error[levels == name]))
                rows.append(
                    {
                        "axis": axis,
                        "level": str(name),
                        "n": int(n),
                        "bias_m": bias,
                        "p_value": p_of[str(name)],
                    }
                )
    for row, p in zip(rows, holm([row["p_value"] for row in rows]), strict=True):
        row["p_value"] = p
    return sorted(rows, key=lambda row: (row["p_value"], -abs(row["bias_m"])))


def holm(p_values: list[float]) -> list[float]:
    """p-values corrected for their number so that one false alarm in all is as rare as promised."""
    adjusted = [1.0] * len(p_values)
    highest = 0.0
    for rank, k in enumerate(np.argsort(p_values, kind="stable")):
        highest = max(highest, min(1.0, (len(p_values) - rank) * p_values[k]))
        adjusted[k] = highest
    return adjusted


def _normal_p(z: Floats) -> float:
    from scipy.special import ndtr  # noqa: PLC0415 (slow)

    return float(2.0 * ndtr(-abs(np.sum(z)) / np.sqrt(len(z))))


def _clustered_p_values(z: Floats, levels: Levels, path: NDArray[np.int64]) -> dict[str, float]:
    """p-value by level; events of one path in one level (a cell) share an offset of unknown spread.

    The spread between cells about the mean of their level is by moments (one-way random effects);
    t has as many degrees of freedom as there are cells less levels. Where every level lies on one
    path only, nothing can be said beyond the paths, and the result is empty.
    """
    from scipy.special import stdtr  # noqa: PLC0415 (slow)

    _, level = np.unique(levels, return_inverse=True)
    names = np.unique(levels)
    _, cell = np.unique(np.column_stack([level, path]), axis=0, return_inverse=True)
    cell = cell.ravel()
    count = np.bincount(cell)
    level_of_cell = np.zeros(len(count), dtype=np.int64)
    level_of_cell[cell] = level
    n_of_level = np.bincount(level)
    free = len(count) - len(names)
    if free < 1:
        return {}
    cell_mean = np.bincount(cell, z) / count
    level_mean = np.bincount(level, z) / n_of_level
    within = 1.0
    if len(z) > len(count):
        within = float(np.sum((z - cell_mean[cell]) ** 2)) / (len(z) - len(count))
    within = max(within, 1.0)
    squares = float(np.sum(count * (cell_mean - level_mean[level_of_cell]) ** 2))
    shared = np.bincount(level_of_cell, count**2.0)
    between = max(0.0, (squares - free * within) / (len(z) - float(np.sum(shared / n_of_level))))
    variance = within / n_of_level + between * shared / n_of_level**2
    t = np.abs(level_mean) / np.sqrt(variance)
    return {str(name): float(2.0 * stdtr(free, -t[k])) for k, name in enumerate(names)}
