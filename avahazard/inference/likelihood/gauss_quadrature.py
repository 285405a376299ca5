"""Gauss quadrature of a discrete measure (Golub and Welsch 1969)."""

from __future__ import annotations

import numpy as np

from avahazard.kernels import kernel

EPSILON, MOST_STEPS = 2.3e-16, 60
LOST = 1e-2
"""Share of a vector that is left of it, from which on it is made orthogonal once more."""


@kernel
def gauss_nodes(points, masses, place, weight):  # type: ignore[no-untyped-def]
    """Gauss nodes of a discrete measure, weights summing to 1 (Lanczos, reorthogonalised)."""
    n, k_max = len(points), len(place)
    total = np.sum(masses)
    centre = np.sum(points * masses) / total
    reach = np.max(np.abs(points - centre))
    if n <= k_max or reach == 0.0:
        place[:], weight[:] = centre, 0.0
        if reach == 0.0:
            weight[0] = 1.0
        else:
            place[:n], weight[:n] = points, masses / total
        return
    x = (points - centre) / reach
    vectors = np.zeros((k_max + 1, n))
    vectors[0] = np.sqrt(masses / total)
    jacobi = np.zeros((k_max, k_max))
    size = k_max
    for k in range(k_max):
        v = x * vectors[k]
        jacobi[k, k] = _inner(v, vectors[k])
        before, norm = 1.0, 0.0
        while norm < LOST * before:
            # Again where little is left of it, in which rounding would count.
            before = np.sqrt(_inner(v, v))
            for j in range(k + 1):
                along = _inner(v, vectors[j])
                for i in range(n):
                    v[i] -= along * vectors[j, i]
            norm = np.sqrt(_inner(v, v))
            if norm < 1e-10:
                break
        if k + 1 == k_max:
            break
        if norm < 1e-10:
            size = k + 1
            break
        jacobi[k, k + 1] = jacobi[k + 1, k] = norm
        vectors[k + 1] = v / norm
    beside, share = np.zeros(size), np.zeros(size)
    values = np.diag(jacobi)[:size].copy()
    for k in range(size - 1):
        beside[k] = jacobi[k, k + 1]
    values_and_shares(values, beside, share)
    place[:], weight[:] = centre, 0.0
    for k in range(size):
        place[k] = centre + reach * values[k]
        weight[k] = share[k] ** 2


@kernel
def values_and_shares(diagonal, beside, first):  # type: ignore[no-untyped-def]
    """Eigenvalues of a symmetric tridiagonal matrix, rising, and their vectors' first components.

    They take the place of the `diagonal` `[n]`; `beside` `[n]`, whose last is 0, is used up. By
    implicit QL steps (Golub and Welsch 1969): of so few quicker than by a library.
    """
    n = len(diagonal)
    first[:] = 0.0
    first[0] = 1.0
    for k in range(n):
        for _ in range(MOST_STEPS):
            m = k
            while m < n - 1:
                if abs(beside[m]) <= EPSILON * (abs(diagonal[m]) + abs(diagonal[m + 1])):
                    break
                m += 1
            if m == k:
                break
            g = (diagonal[k + 1] - diagonal[k]) / (2.0 * beside[k])
            r = np.sqrt(g * g + 1.0)
            g = diagonal[m] - diagonal[k] + beside[k] / (g + (r if g >= 0.0 else -r))
            s, c, p = 1.0, 1.0, 0.0
            whole = True
            for i in range(m - 1, k - 1, -1):
                f, b = s * beside[i], c * beside[i]
                r = np.sqrt(f * f + g * g)
                beside[i + 1] = r
                if r == 0.0:
                    diagonal[i + 1] -= p
                    beside[m] = 0.0
                    whole = False
                    break
                s, c = f / r, g / r
                g = diagonal[i + 1] - p
                r = (diagonal[i] - g) * s + 2.0 * c * b
                p = s * r
                diagonal[i + 1] = g + p
                g = c * r - b
                low, high = first[i], first[i + 1]
                first[i + 1], first[i] = s * low + c * high, c * low - s * high
            if whole:
                diagonal[k] -= p
                beside[k] = g
                beside[m] = 0.0
    for k in range(1, n):
        value, share, j = diagonal[k], first[k], k
        while j > 0 and diagonal[j - 1] > value:
            diagonal[j], first[j] = diagonal[j - 1], first[j - 1]
            j -= 1
        diagonal[j], first[j] = value, share


@kernel
def _inner(a, b):  # type: ignore[no-untyped-def]
    """The sum of a b, in four sums that do not wait for each other."""
    s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
    whole = len(a) - len(a) % 4
    for i in range(0, whole, 4):
        s0 += a[i] * b[i]
        s1 += a[i + 1] * b[i + 1]
        s2 += a[i + 2] * b[i + 2]
        s3 += a[i + 3] * b[i + 3]
    for i in range(whole, len(a)):
        s0 += a[i] * b[i]
    return (s0 + s1) + (s2 + s3)
