"""Gauss quadrature of a discrete measure (Golub and Welsch 1969)."""

from __future__ import annotations

import numpy as np

from avahazard.kernels import kernel


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
        jacobi[k, k] = np.sum(v * vectors[k])
        for _ in range(2):
            for j in range(k + 1):
                v -= np.sum(v * vectors[j]) * vectors[j]
        norm = np.sqrt(np.sum(v * v))
        if k + 1 == k_max:
            break
        if norm < 1e-10:
            size = k + 1
            break
        jacobi[k, k + 1] = jacobi[k + 1, k] = norm
        vectors[k + 1] = v / norm
    values, eigenvectors = np.linalg.eigh(jacobi[:size, :size])
    place[:], weight[:] = centre, 0.0
    for k in range(size):
        place[k] = centre + reach * values[k]
        weight[k] = eigenvectors[0, k] ** 2
