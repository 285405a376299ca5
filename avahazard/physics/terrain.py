"""The regularised path cut into cells, with the geometry that the block needs."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss, legint, legval, legvander
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile

MAX_CELL_M = 20.0
MAX_TURN = 0.05
"""Largest change of the slope angle within a cell, radians: it bounds the error of the series."""
PLAIN_M, N_PROBES = 200.0, 33
"""Length of the intervals (m) in which turns are looked for, at so many places each."""
GAUSS_X, GAUSS_W = leggauss(6)
TO_PARTIAL_LENGTHS = legval(GAUSS_X, legint(np.eye(6), lbnd=-1.0)).T @ np.linalg.inv(
    legvander(GAUSS_X, 5)
)
"""The matrix that makes integrals up to the Gauss points of a function's values there."""


@dataclass(frozen=True, slots=True, eq=False)
class Terrain:
    """Cells of a path: nodes `[n_cells + 1]` and Gauss points `[n_cells, 6]`.

    `theta` is the slope angle -atan f' (> 0 downhill), `bend` = dθ/dx, `s` the arc length (m)
    from the top, `weight` the quadrature weights in x. Curvature is κ = -bend·cosθ.
    """

    x: Floats
    y: Floats
    theta: Floats
    bend: Floats
    s: Floats
    gauss_x: Floats
    gauss_theta: Floats
    gauss_bend: Floats
    gauss_s: Floats
    weight: Floats

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return len(self.x) - 1

    @property
    def middle_x(self) -> Floats:
        """Middle of each cell, `[n_cells]`."""
        return 0.5 * (self.x[1:] + self.x[:-1])

    @property
    def middle_y(self) -> Floats:
        """Mean elevation of each cell's ends, `[n_cells]`."""
        return 0.5 * (self.y[1:] + self.y[:-1])

    def node(self, x: float) -> int:
        """Index of the node at x, one of the breaks that the cells were built with."""
        return node_of(self.x, x)


def node_of(nodes: Floats, x: float) -> int:
    """Index of x among the nodes of a terrain. Raises `ValueError` where it is none of them."""
    i = int(np.searchsorted(nodes, x))
    if i == len(nodes) or nodes[i] != x:
        raise ValueError(f"x = {x} is not a node of the terrain")
    return i


def build_terrain(
    profile: SmoothProfile, breaks: Floats | None = None, max_cell: float = MAX_CELL_M
) -> Terrain:
    """Cut the profile into cells, with nodes at every one of `breaks` `[n_breaks]`.

    Cells end at the knots of the profile and are chosen by error: none is longer than
    `max_cell` metres or turns by more than `MAX_TURN`.
    """
    return terrain_at(profile, cell_ends(profile, breaks, max_cell))


def cell_ends(profile: SmoothProfile, breaks: Floats | None, max_cell: float) -> Floats:
    """The nodes x `[n_cells + 1]` (m) of `build_terrain`."""
    inner = np.concatenate([profile.knots, np.asarray([] if breaks is None else breaks)])
    inner = inner[(inner > profile.x_min) & (inner < profile.x_max)]
    coarse = np.unique(np.concatenate([[profile.x_min, profile.x_max], inner]))
    # Long intervals are first cut plainly, so that the probes see every turn.
    coarse = _split(coarse, np.ceil(np.diff(coarse) / PLAIN_M).astype(int))
    width, probes = np.diff(coarse), np.linspace(0.0, 1.0, N_PROBES)
    slope = profile.derivatives(coarse[:-1, None] + width[:, None] * probes)[1]
    # As if all of an interval turned like its sharpest part.
    turn = (N_PROBES - 1) * np.max(np.abs(np.diff(np.arctan(slope), axis=1)), axis=1)
    return _split(coarse, np.ceil(np.maximum(width / max_cell, turn / MAX_TURN)).astype(int))


def terrain_at(profile: SmoothProfile, x: Floats) -> Terrain:
    """Cells of the profile between these nodes x `[n_cells + 1]`."""
    y, slope, f2 = profile.derivatives(x)
    half = 0.5 * np.diff(x)[:, None]
    gauss_x = x[:-1, None] + half * (1.0 + GAUSS_X)
    _, gauss_slope, gauss_f2 = profile.derivatives(gauss_x)
    weight = half * GAUSS_W
    stretch = np.hypot(1.0, gauss_slope)
    s = np.concatenate([[0.0], np.cumsum(np.sum(weight * stretch, axis=1))])
    return Terrain(
        x=x,
        y=y,
        theta=-np.arctan(slope),
        bend=-f2 / (1.0 + slope**2),
        s=s,
        gauss_x=gauss_x,
        gauss_theta=-np.arctan(gauss_slope),
        gauss_bend=-gauss_f2 / (1.0 + gauss_slope**2),
        gauss_s=s[:-1, None] + half * (stretch @ TO_PARTIAL_LENGTHS.T),
        weight=weight,
    )


def _split(nodes: Floats, pieces: NDArray[np.int_]) -> Floats:
    """Cut interval i of `nodes` into `pieces[i]` equal parts."""
    start = np.repeat(nodes[:-1], pieces)
    width = np.repeat(np.diff(nodes) / pieces, pieces)
    first = np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.append(start + width * (np.arange(len(start)) - first), nodes[-1])
