"""Quadrature of likelihoods that are wide against the scatter of friction.

Gauss nodes of a record lie as far apart as the record is vague. Where that is more than the
scatter, the density of the scatter falls between them: records with large errors then seem to say
which scatter, and which friction, meets the nodes. A wide likelihood is cut into panels of one
width, each with the two Gauss nodes of its part, close enough for the least scatter that a model
may have.
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.inference.likelihood.gauss_quadrature import gauss_nodes
from avahazard.inference.model.layout import least_scatter
from avahazard.kernels import kernel

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
    reach = np.max(np.where(used, place, -np.inf), axis=1, initial=-np.inf) - np.min(
        np.where(used, place, np.inf), axis=1, initial=np.inf
    )
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
