"""Where a model fails: its bias along every axis, and whether chance could do that."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.criticism.scoring.axes import Levels
from avahazard.criticism.scoring.contrasts import contrast_p_values
from avahazard.results.base import Rows
from avahazard.results.comparison import Failure

MIN_EVENTS = 5
MIN_PATHS = 5
PIT_EDGE = 1e-6


def where_it_fails(
    axes: Mapping[str, Levels], error: Floats, pit: Floats, path: NDArray[np.int64]
) -> Rows[Failure]:
    """The bias of each level of each axis, the least likely first.

    `error` `[n_events]` is predicted mean less record (m), `pit` the rank of the record in its
    predictive distribution, `path` the index of each event's path. The p-value is that of the
    mean of Φ⁻¹(PIT) in a level (two-sided). Events of one path are not independent: with five
    paths or more, axes other than the path allow for a spread between paths, and a level is held
    against the other events (`contrasts`). Values are corrected
    for the number of axes, which count alike and share their part among their levels (`holm`):
    a column of thirty words hides no other. Levels of fewer than five events are left out.
    """
    from scipy.special import ndtri  # noqa: PLC0415 (slow)

    z = ndtri(np.clip(pit, PIT_EDGE, 1.0 - PIT_EDGE))
    clustered = len(np.unique(path[path >= 0])) >= MIN_PATHS
    rows: list[Failure] = []
    for axis, levels in axes.items():
        known = levels != ""
        names, counts = np.unique(levels[known], return_counts=True)
        if len(names) < 2:
            continue
        if clustered and axis != "path":
            p_of = contrast_p_values(z[known], levels[known], path[known])
        else:
            p_of = {str(name): _normal_p(z[levels == name]) for name in names}
        for name, n in zip(names, counts, strict=True):
            if n >= MIN_EVENTS and str(name) in p_of:
                bias = float(np.mean(error[levels == name]))
                rows.append(Failure(axis, str(name), int(n), bias, p_of[str(name)]))
    levels_of = Counter(row.axis for row in rows)
    corrected = holm([row.p_value for row in rows], [1.0 / levels_of[row.axis] for row in rows])
    rows = [replace(row, p_value=p) for row, p in zip(rows, corrected, strict=True)]
    return Rows(sorted(rows, key=lambda row: (row.p_value, -abs(row.bias_m))))


def holm(p_values: list[float], weights: list[float]) -> list[float]:
    """p-values corrected so that one false alarm in all is as rare as promised.

    A p-value counts by its weight in what it is held against (weighted procedure of Holm 1979).
    """
    adjusted = [1.0] * len(p_values)
    highest, left = 0.0, sum(weights)
    order = np.argsort(np.divide(p_values, weights), kind="stable")
    for k in order:
        highest = max(highest, min(1.0, left * p_values[k] / weights[k]))
        adjusted[k] = highest
        left -= weights[k]
    return adjusted


def _normal_p(z: Floats) -> float:
    from scipy.special import ndtr  # noqa: PLC0415 (slow)

    return float(2.0 * ndtr(-abs(np.sum(z)) / np.sqrt(len(z))))
