"""Gauss quadrature of a discrete measure (Golub and Welsch 1969), in panels where it is wide.

The scatter would fall between the Gauss nodes of a vague record, which would then seem to say which
scatter meets them. So a wide likelihood is cut into panels of one width with two nodes each.
"""

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.inference.model.layout import least_scatter
from avahazard.kernels import kernel

LOST = 1e-2
"""Share of a vector that is left of it, from which on it is made orthogonal once more."""


@kernel
def gauss_nodes(points, masses, place, weight):  # type: ignore[no-untyped-def]
    """Gauss nodes of a discrete measure, weights summing to 1 (Lanczos, reorthogonalised)."""
    n, k_max = len(points), len(place)
    total = np.sum(masses)
    centre = np.sum(points * masses) / total
    place[:], weight[:] = centre, 0.0
    x = points - centre
    reach = np.max(np.abs(x))
    if reach == 0.0:
        weight[0] = 1.0
        return
    if n <= k_max:
        place[:n], weight[:n] = points, masses / total
        return
    x /= reach
    vectors = np.zeros((k_max + 1, n))
    vectors[0] = np.sqrt(masses / total)
    jacobi, size = np.zeros((k_max, k_max)), k_max
    for k in range(k_max):
        v = x * vectors[k]
        jacobi[k, k] = _inner(v, vectors[k])
        norm = _orthogonalised(v, vectors[: k + 1])
        if k + 1 == k_max:
            break
        if norm < 1e-10:
            size = k + 1
            break
        jacobi[k + 1, k] = jacobi[k, k + 1] = norm
        vectors[k + 1] = v / norm
    values, directions = np.linalg.eigh(jacobi[:size, :size].copy())
    place[:size] += reach * values
    weight[:size] = directions[0] ** 2


@kernel(inner=True)
def _orthogonalised(v, vectors):  # type: ignore[no-untyped-def]
    """Take the parts along `vectors` from v, again where rounding would count; its norm."""
    before, norm = 1.0, 0.0
    while norm < LOST * before:
        before = np.sqrt(_inner(v, v))
        for vector in vectors:
            along = _inner(v, vector)
            for i in range(len(v)):
                v[i] -= along * vector[i]
        norm = np.sqrt(_inner(v, v))
        if norm < 1e-10:
            break
    return norm


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


N_NODES = 10
"""Nodes of a likelihood that is narrow enough for Gauss's."""
NARROW = 2.0
"""Standard deviation, in least scatters, up to which 10 Gauss nodes err by less than 4 % even for
the least scatter (0.004 % for twice that)."""
PANEL = 2.0
"""Width of a panel in least scatters."""
A_PANEL = 2
"""Nodes of a panel."""
MARGIN = 1.9
"""Support of a normal likelihood (to e^-40) against the reach of its 10 Gauss nodes."""


def panel_width(in_log: bool) -> float:
    """Width of a panel, in log friction or in friction."""
    return PANEL * least_scatter(in_log)


def finest(in_log: bool) -> float:
    """Farthest that points of a likelihood may lie apart, several in each panel."""
    return 0.25 * panel_width(in_log)


def n_panels(place: Floats, weight: Floats, in_log: bool) -> Ints:
    """Panels that each event needs `[n_events]`, from its Gauss nodes; 1 where those will do."""
    mean = np.sum(place * weight, axis=1, keepdims=True)
    spread = np.sqrt(np.sum(weight * (place - mean) ** 2, axis=1))
    used = weight > 0.0
    reach = np.max(place, axis=1, where=used, initial=-np.inf)
    reach = reach - np.min(place, axis=1, where=used, initial=np.inf)
    wide = used.any(axis=1) & (spread > NARROW * least_scatter(in_log))
    panels = np.ceil(MARGIN * np.where(wide, reach, 0.0) / panel_width(in_log))
    return np.maximum(panels, 1.0).astype(np.int64)


def nodes_used(panels: Ints) -> Ints:
    """Nodes of events with so many panels."""
    return np.maximum(A_PANEL * panels, N_NODES)


@kernel
def panel_nodes(points, masses, panels, place, weight):  # type: ignore[no-untyped-def]
    """Nodes of a discrete measure, weights summing to 1: Gauss's, or two in each of many `panels`.

    `points` rise. Nodes that are not used have weight 0.
    """
    if A_PANEL * panels <= N_NODES:
        gauss_nodes(points, masses, place[:N_NODES], weight[:N_NODES])
        place[N_NODES:], weight[N_NODES:] = place[0], 0.0
        return
    place[:], weight[:] = points[0], 0.0
    total = np.sum(masses)
    width = (points[-1] - points[0]) / panels
    first = 0
    for k in range(panels):
        last = first
        edge = points[0] + (k + 1) * width
        while last < len(points) and (points[last] <= edge or k == panels - 1):
            last += 1
        if last > first:
            here = slice(A_PANEL * k, A_PANEL * (k + 1))
            _two_nodes(points[first:last], masses[first:last], place[here], weight[here])
            first = last
    weight /= total


@kernel(inner=True)
def _two_nodes(points, masses, place, weight):  # type: ignore[no-untyped-def]
    """The two Gauss nodes of a few points, from their first three moments."""
    mass = np.sum(masses)
    mean = np.sum(masses * points) / mass if mass > 0.0 else points[0]
    away = points - mean
    variance = np.sum(masses * away**2) / mass if mass > 0.0 else 0.0
    place[:], weight[:] = mean, 0.5 * mass
    if variance > 1e-16:
        skew = np.sum(masses * away**3) / mass / variance
        root = np.sqrt(skew * skew + 4.0 * variance)
        place[0], place[1] = mean + 0.5 * (skew - root), mean + 0.5 * (skew + root)
        weight[0] = mass * 0.5 * (skew + root) / root
        weight[1] = mass - weight[0]
