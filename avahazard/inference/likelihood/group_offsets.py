"""Offsets of groups of events at given parameters: Newton's method, all groups at once.

A fixed number of steps keeps the result a smooth function of the parameters, as finite
differences of it need.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.offset_system import (
    by_offset,
    log_determinant,
    offset_system,
    solved,
)
from avahazard.inference.likelihood.term_kernels import event_terms_kernel
from avahazard.kernels import kernel

EVALUATIONS = 3
LONGEST_STEP = 0.5
LARGEST = 1e8
"""Curvature that is believed of one event; far off it overflows."""


class Offsets(NamedTuple):
    """Offsets of log friction by group: their mode `[n_offsets]`, and the normal about it.

    `rest`, `bend`, `cross`, `root` are those of `offset_system`.
    """

    mode: Floats
    rest: NDArray[np.int64]
    bend: Floats
    cross: Floats
    root: Floats

    def draw(self, rng: np.random.Generator) -> Floats:
        """One draw of all offsets `[n_offsets]`."""
        away = rng.standard_normal(len(self.mode)) * (1.0 / np.sqrt(self.bend))
        if len(self.root):
            others = self.rest >= 0
            z = rng.standard_normal(len(self.root))
            away[others] = np.linalg.solve(self.root.T, z)
            away[~others] -= (self.cross[~others] @ away[others]) / self.bend[~others]
        return np.asarray(self.mode + away)

    @property
    def log_determinant(self) -> float:
        """That of the precision."""
        return float(log_determinant(self.rest, self.bend, self.root))


@kernel
def newton_offsets(  # type: ignore[no-untyped-def]
    nodes, location, scatter, volume_weight, student, in_log, index, rest, keep, precision
):
    """Mode of the offsets, their `offset_system` there, and log likelihoods `[n_events]`.

    Events not in `keep` do not count and have no likelihood (0). Offsets have normal priors of
    this `precision` `[n_offsets]`. `in_log`: they add to `location`, else they multiply it by
    their exponential.
    """
    n, n_volumes = location.shape
    n_groupings = len(index)
    g, h = _as_if_normal(nodes, location, scatter, in_log, keep)
    bend, cross, root = offset_system(index, rest, h, keep, precision)
    offsets = solved(rest, bend, cross, root, by_offset(index, keep, g, len(precision)))
    for k in range(len(offsets)):
        offsets[k] = min(max(offsets[k], -LONGEST_STEP), LONGEST_STEP)
    shifted = location.copy()
    slopes = bool(1)  # for a constant the called kernel would be compiled once more
    for step in range(EVALUATIONS):
        for i in range(n):
            if not keep[i]:
                continue
            move = 0.0
            grouped = False
            for a in range(n_groupings):
                if index[a, i] >= 0:
                    move += offsets[index[a, i]]
                    grouped = True
            if grouped:
                for q in range(n_volumes):
                    shifted[i, q] = (
                        location[i, q] + move if in_log else location[i, q] * np.exp(move)
                    )
        value, by_location, _, curvature = event_terms_kernel(
            nodes, shifted, scatter, volume_weight, student, keep, slopes
        )
        for i in range(n):
            # Where the offset acts on log μ, m changes by m per unit.
            level = 1.0 if in_log else np.mean(shifted[i])
            g[i] = np.sum(by_location[i]) * level
            h[i] = min(max(-curvature[i] * level * level, 0.0), LARGEST)
        bend, cross, root = offset_system(index, rest, h, keep, precision)
        if step < EVALUATIONS - 1:
            slope = by_offset(index, keep, g, len(precision)) - precision * offsets
            change = solved(rest, bend, cross, root, slope)
            for k in range(len(offsets)):
                offsets[k] += min(max(change[k], -LONGEST_STEP), LONGEST_STEP)
    return offsets, bend, cross, root, value


@kernel(inner=True)
def _as_if_normal(nodes, location, scatter, in_log, keep):  # type: ignore[no-untyped-def]
    """Score and curvature in the shift of each event, as if every likelihood were normal.

    0 for events that left their profile.
    """
    n = len(location)
    g, h = np.zeros(n), np.zeros(n)
    for i in range(n):
        if not keep[i] or nodes.is_probability[i]:
            continue
        total, first, second = 0.0, 0.0, 0.0
        for k in range(nodes.used[i]):
            total += nodes.weight[i, k]
            first += nodes.weight[i, k] * nodes.place[i, k]
            second += nodes.weight[i, k] * nodes.place[i, k] ** 2
        if total <= 0.0:
            continue
        mean = first / total
        m, variance = np.mean(location[i]), max(second / total - mean * mean, 0.0)
        variance += np.mean(scatter[i]) ** 2 + np.var(location[i])
        level = 1.0 if in_log else m
        g[i] = (mean - m) * level / variance
        h[i] = level * level / variance
    return g, h
