"""The linear system of crossed offsets, those of the largest grouping eliminated first.

Two offsets of one grouping share no event, so that the largest grouping has a diagonal block;
what is left of the others is dense, and small. An offset of the largest grouping meets few of the
others, as many as a path has winters with events: sums over it go through these alone.
"""

from __future__ import annotations

import math

import numpy as np

from avahazard.kernels import kernel


@kernel(inner=True)
def offset_system(index, rest, h, keep, precision):  # type: ignore[no-untyped-def]
    """Precision of the offsets: `bend` `[n_offsets]`, `cross`, and Cholesky's root of the others.

    `index` `[n_groupings, n_events]` and `rest` `[n_offsets]` as in `OffsetPlan`, `h` `[n_events]`
    is the curvature of each event in its shift (≥ 0), `precision` `[n_offsets]` that of the prior.
    `bend` is the diagonal; `cross` `[n_offsets, n_rest]` joins the largest grouping to the others;
    `root` `[n_rest, n_rest]` is that of the Schur complement.
    """
    n_rest = 0
    for k in range(len(rest)):
        n_rest = max(n_rest, rest[k] + 1)
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
    return bend, cross, np.linalg.cholesky(inner)


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
def solved(rest, bend, cross, root, slope):  # type: ignore[no-untyped-def]
    """The step `[n_offsets]` that the system gives for a slope `[n_offsets]`."""
    step = slope / bend
    n_rest = len(root)
    if not n_rest:
        return step
    right = np.zeros(n_rest)
    for k in range(len(rest)):
        if rest[k] >= 0:
            right[rest[k]] = slope[k]
    for k in range(len(rest)):
        if rest[k] < 0:
            right -= cross[k] * step[k]
    other = _upper(root, _lower(root, right))
    for k in range(len(rest)):
        if rest[k] >= 0:
            step[k] = other[rest[k]]
        else:
            step[k] -= np.dot(cross[k], other) / bend[k]
    return step


@kernel(inner=True)
def _lower(root, right):  # type: ignore[no-untyped-def]
    """x of root x = right."""
    x = right.copy()
    for r in range(len(root)):
        for c in range(r):
            x[r] -= root[r, c] * x[c]
        x[r] /= root[r, r]
    return x


@kernel(inner=True)
def _upper(root, right):  # type: ignore[no-untyped-def]
    """x of rootᵀ x = right."""
    x = right.copy()
    for r in range(len(root) - 1, -1, -1):
        for c in range(r + 1, len(root)):
            x[r] -= root[c, r] * x[c]
        x[r] /= root[r, r]
    return x


@kernel(inner=True)
def variances(rest, bend, cross, root):  # type: ignore[no-untyped-def]
    """Variance of each offset `[n_offsets]` given nothing but the data and the priors."""
    result = 1.0 / bend
    if not len(root):
        return result
    half = _inverse(root)
    others = np.dot(half.T, half)
    for k in range(len(rest)):
        if rest[k] >= 0:
            result[k] = others[rest[k], rest[k]]
            continue
        met = np.nonzero(cross[k])[0]
        for r in met:
            for c in met:
                result[k] += cross[k, r] * others[r, c] * cross[k, c] / (bend[k] * bend[k])
    return result


@kernel(inner=True)
def _inverse(root):  # type: ignore[no-untyped-def]
    """Inverse of a lower root, row by row."""
    inverse = np.zeros_like(root)
    for r in range(len(root)):
        inverse[r, r] = 1.0
        for c in range(r):
            for k in range(c + 1):
                inverse[r, k] -= root[r, c] * inverse[c, k]
        for k in range(r + 1):
            inverse[r, k] /= root[r, r]
    return inverse


@kernel
def log_determinant(rest, bend, root):  # type: ignore[no-untyped-def]
    """Log determinant of the precision of all offsets."""
    total = 0.0
    for k in range(len(rest)):
        if rest[k] < 0:
            total += math.log(bend[k])
    for r in range(len(root)):
        total += 2.0 * math.log(root[r, r])
    return total
