"""Offsets of groups of events at given parameters: Newton's method, all groups at once.

A fixed number of steps keeps the result smooth in the parameters. Two offsets of one grouping share
no event, so the largest grouping has a diagonal block and is eliminated first.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.terms import EventTerms, event_terms_kernel
from avahazard.kernels import kernel


@kernel(inner=True)
def offset_system(index, rest, h, keep, precision):  # type: ignore[no-untyped-def]
    """Precision of the offsets: `bend` `[n_offsets]`, `cross`, and `back`.

    `index` `[n_groupings, n_events]` and `rest` `[n_offsets]` as in `OffsetPlan`, `h` `[n_events]`
    is the curvature of each event in its shift (≥ 0), `precision` `[n_offsets]` that of the prior.
    `bend` is the diagonal; `cross` `[n_offsets, n_rest]` joins the largest grouping to the others;
    `back` `[n_rest, n_rest]` is the inverse of the Schur complement's root.
    """
    n_rest = np.sum(rest >= 0)
    bend = precision + by_offset(index, keep, h, len(rest))
    cross = np.zeros((len(rest) if n_rest else 0, n_rest))
    inner = np.zeros((n_rest, n_rest))
    if not n_rest:
        return bend, cross, inner
    for i in range(len(h)):
        if keep[i]:
            _join(index[:, i], rest, h[i], cross, inner)
    for k in range(len(rest)):
        if rest[k] >= 0:
            inner[rest[k], rest[k]] += bend[k]
            continue
        met = np.nonzero(cross[k])[0]
        for r in met:
            weight = cross[k, r] / bend[k]
            for c in met:
                inner[r, c] -= weight * cross[k, c]
    if not np.all(np.isfinite(inner)):  # no likelihood there, which the decomposition would raise
        return bend, cross, np.full_like(inner, np.nan)
    return bend, cross, np.ascontiguousarray(np.linalg.inv(np.linalg.cholesky(inner)))


@kernel(inner=True)
def _join(groups, rest, h, cross, inner):  # type: ignore[no-untyped-def]
    """Add what one event of curvature h says of the offsets of its `groups` together."""
    for k in groups:
        for j in groups:
            if k < 0 or j < 0 or j == k or rest[j] < 0:
                continue
            if rest[k] < 0:
                cross[k, rest[j]] += h
            else:
                inner[rest[k], rest[j]] += h


@kernel(inner=True)
def by_offset(index, keep, g, n_offsets):  # type: ignore[no-untyped-def]
    """Sum of g `[n_events]` over the events of each offset."""
    total = np.zeros(n_offsets)
    for i in range(len(g)):
        if keep[i]:
            for a in range(len(index)):
                if index[a, i] >= 0:
                    total[index[a, i]] += g[i]
    return total


@kernel
def solved(rest, bend, cross, back, slope):  # type: ignore[no-untyped-def]
    """The step `[n_offsets]` that the system gives for a slope `[n_offsets]`."""
    step = slope / bend
    if len(back):
        others = rest >= 0
        step[others] = 0.0
        other = back.T @ (back @ (slope[others] - cross.T @ step))
        step -= (cross @ other) / bend
        step[others] = other
    return step


EVALUATIONS = 3
LONGEST_STEP = 0.5
LARGEST = 1e8
"""Curvature that is believed of one event; far off it overflows."""


class Offsets(NamedTuple):
    """Offsets of log friction by group: their mode `[n_offsets]`, and the normal about it.

    `rest`, `bend`, `cross`, `back` are those of `offset_system`.
    """

    mode: Floats
    rest: NDArray[np.int64]
    bend: Floats
    cross: Floats
    back: Floats

    def draw(self, rng: np.random.Generator) -> Floats:
        """One draw of all offsets `[n_offsets]`."""
        away = rng.standard_normal(len(self.mode)) * (1.0 / np.sqrt(self.bend))
        if len(self.back):
            others = self.rest >= 0
            away[others] = self.back.T @ rng.standard_normal(len(self.back))
            away[~others] -= (self.cross[~others] @ away[others]) / self.bend[~others]
        return np.asarray(self.mode + away)

    @property
    def log_determinant(self) -> float:
        """That of the precision."""
        of_others = 2.0 * np.sum(np.log(np.diag(self.back)))
        return float(np.sum(np.log(self.bend[self.rest < 0])) - of_others)

    def variances(self, index: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """Variance of each offset `[n_offsets]`, and of each event's sum of them `[n_events]`.

        `index` is as in `OffsetPlan`.
        """
        alone, others = 1.0 / self.bend, self.rest >= 0
        shared = np.zeros((len(alone) + 1, len(self.back)))  # covariance with the others; 0 for -1
        if others.any():
            inverse = self.back.T @ self.back
            shared[:-1] = -(self.cross @ inverse) * alone[:, None]
            alone -= np.sum(shared[:-1] * self.cross, axis=1) * alone
            shared[:-1][others] = inverse
            alone[others] = np.diag(inverse)
        summed, rest = np.append(alone, 0.0)[index].sum(axis=0), np.append(self.rest, -1)
        for one in index:
            for other in index:
                joined = (rest[other] >= 0) & (one != other) & (one >= 0)
                # A pair with one of the largest grouping is met once, any other twice.
                twice = np.where(rest[one] >= 0, 1.0, 2.0)[joined]
                summed[joined] += twice * shared[one[joined], rest[other[joined]]]
        return alone, summed


APART = 1e-3
"""Shift of log friction over which derivatives of the events' terms are taken."""


def pulls_of_groups(
    offsets: Offsets,
    index: NDArray[np.int64],
    precision: Floats,
    terms_at: Callable[[Floats], EventTerms],
) -> tuple[Floats, Floats, Floats]:
    """Derivatives of a likelihood of which offsets of groups are integrated out (`newton_offsets`).

    By location and by log scatter `[n_events, n_volumes]` of the events, and by the log of the
    spread of each offset `[n_offsets]`; `terms_at` shifts `[n_events]` of log friction. They are
    those of ℓ and of log|H|/2 (docs/theory/likelihood.md, "All records"), in which events count by
    the variance of their shift.
    """
    mode = offsets.mode
    shift = np.append(mode, 0.0)[index].sum(axis=0)
    behind, here, ahead = (terms_at(shift + step) for step in (-APART, 0.0, APART))

    def bends(name: str) -> tuple[Floats, Floats, Floats]:
        a, b, c = (getattr(at, name) for at in (behind, here, ahead))
        return b, (c - a) / (2.0 * APART), (c - 2.0 * b + a) / APART**2

    variance, of_events = offsets.variances(index)
    of_events = np.where((here.curvature < 0.0) & (here.curvature > -LARGEST), of_events, 0.0)
    turned = np.zeros(len(mode) + 1)
    third = -of_events * np.sum(bends("by_location")[2], axis=1)
    np.add.at(turned, index, np.broadcast_to(third, index.shape))
    moved = solved(*offsets[1:], turned[:-1])
    along = np.append(moved, 0.0)[index].sum(axis=0)
    by_location, by_scatter = (
        first + 0.5 * (of_events[:, None] * curved - along[:, None] * bent)
        for first, bent, curved in map(bends, ("by_location", "by_scatter"))
    )
    by_log_spread = precision * (mode**2 + variance - moved * mode) - 1.0
    return by_location, by_scatter, by_log_spread


@kernel
def newton_offsets(  # type: ignore[no-untyped-def]
    nodes, location, scatter, volume_weight, student, in_log, index, rest, keep, precision
):
    """Mode of the offsets, their `offset_system` there, and log likelihoods `[n_events]`.

    Events not in `keep` do not count and have no likelihood (0). Offsets have normal priors of
    this `precision` `[n_offsets]`. `in_log`: they add to `location`, else they multiply it by
    their exponential.
    """
    n = len(location)
    offsets, shifted, value = np.zeros(len(precision)), location.copy(), np.zeros(n)
    slopes = bool(1)  # for a constant the called kernel would be compiled once more
    g, h = _as_if_normal(nodes, location, scatter, in_log, keep)
    for step in range(EVALUATIONS + 1):
        if step > 0:
            _shift(location, offsets, index, in_log, shifted)
            value, by_location, _, curvature, _ = event_terms_kernel(
                nodes, volume_weight, student, keep, slopes, shifted, scatter
            )
            for i in range(n):
                # Where the offset acts on log μ, m changes by m per unit.
                level = 1.0 if in_log else np.mean(shifted[i])
                g[i] = np.sum(by_location[i]) * level
                h[i] = min(max(-curvature[i] * level * level, 0.0), LARGEST)
        bend, cross, back = offset_system(index, rest, h, keep, precision)
        if step < EVALUATIONS:
            slope = by_offset(index, keep, g, len(precision)) - precision * offsets
            change = solved(rest, bend, cross, back, slope)
            for k in range(len(offsets)):
                offsets[k] += min(max(change[k], -LONGEST_STEP), LONGEST_STEP)
    return offsets, bend, cross, back, value


@kernel(inner=True)
def _shift(location, offsets, index, in_log, shifted):  # type: ignore[no-untyped-def]
    """Fill in `shifted` `[n_events, n_volumes]`, the location with the offsets of each event."""
    for i in range(len(location)):
        move = 0.0
        for a in range(len(index)):
            if index[a, i] >= 0:
                move += offsets[index[a, i]]
        for q in range(location.shape[1]):
            shifted[i, q] = location[i, q] + move if in_log else location[i, q] * np.exp(move)


@kernel(inner=True)
def _as_if_normal(nodes, location, scatter, in_log, keep):  # type: ignore[no-untyped-def]
    """Score and curvature in the shift of each event, as if every likelihood were normal.

    0 for events beyond the profile.
    """
    n = len(location)
    g, h = np.zeros(n), np.zeros(n)
    for i in range(n):
        place, weight = nodes.place[i, : nodes.used[i]], nodes.weight[i, : nodes.used[i]]
        total = np.sum(weight)
        if not keep[i] or nodes.is_probability[i] or total <= 0.0:
            continue
        mean = np.sum(weight * place) / total
        m, variance = np.mean(location[i]), np.sum(weight * (place - mean) ** 2) / total
        variance += np.mean(scatter[i]) ** 2 + np.var(location[i])
        level = 1.0 if in_log else m
        g[i] = (mean - m) * level / variance
        h[i] = level * level / variance
    return g, h
