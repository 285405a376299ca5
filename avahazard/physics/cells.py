"""What resists the block, and terrain with it in the form that the kernel runs over.

In a cell the square of speed has the exact step w₁ = A(μ) w₀ + B(μ) (docs/theory/motion.md). Both
are expanded in powers of μ, exactly to the order kept: the cells turn so little that the rest is
below 1e-8 of w.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.terrain import Terrain

GRAVITY = 9.81
"""Acceleration of gravity, m/s²."""


SPEED_STEP = 0.5
"""Spacing of the tables over speed, m/s."""
SPEEDS = np.arange(0.0, 150.0 + SPEED_STEP, SPEED_STEP)
"""Speeds at which effects that depend on speed are tabulated, m/s `[n_speeds]`."""
NEUTRAL_FACTOR, NEUTRAL_CONSTANT = np.ones(len(SPEEDS)), np.zeros(len(SPEEDS))
"""Those tables where nothing depends on speed."""


@dataclass(frozen=True, slots=True, eq=False)
class Resistance:
    """Resisting force per mass in each cell: m(x) s(u) μ N + o(x) N + c(x) + r(u) + d(x) u².

    `factor` m and `offset` o change the friction, `constant` c is in m/s², `drag` d in 1/m, all
    `[n_cells]`; `speed_factor` s and `speed_constant` r (m/s²) are tabulated at `SPEEDS`.
    `curvature` scales the centrifugal load (1, or 0 where it is left out).
    """

    factor: Floats
    offset: Floats
    constant: Floats
    drag: Floats
    curvature: float = 1.0
    speed_factor: Floats = field(default_factory=lambda: NEUTRAL_FACTOR)
    speed_constant: Floats = field(default_factory=lambda: NEUTRAL_CONSTANT)


def no_resistance(terrain: Terrain) -> Resistance:
    """The base model: Coulomb friction alone."""
    n = terrain.n_cells
    return Resistance(np.ones(n), np.zeros(n), np.zeros(n), np.zeros(n))


ORDER = 6
"""Highest power of μ kept."""


class Cells(NamedTuple):
    """Arrays over cells `[n_cells]` or nodes `[n_cells + 1]`; powers of μ stand lowest first.

    `growth`, `drive` `[n_cells, ORDER + 1]` are A and B; below `dip` a minimum inside the cell
    may touch zero; above `lift` the block may lose the ground. `slope` is tanθ, `steepening` its
    derivative, `bend` = dθ/dx; `curvature` scales the centrifugal load. `speed_resists`: some
    `speed_constant` is not zero.
    """

    x: Floats
    y: Floats
    slope: Floats
    steepening: Floats
    bend: Floats
    growth: Floats
    drive: Floats
    factor: Floats
    offset: Floats
    constant: Floats
    drag: Floats
    dip: Floats
    lift: Floats
    length: Floats
    speed_factor: Floats
    speed_constant: Floats
    speed_dependent: bool
    speed_resists: bool
    curvature: float


@lru_cache(maxsize=64)
def _ground(terrain: Terrain, curvature: float) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """What cells take from the terrain alone, kept of a few: the last three as in `Cells`.

    tanθ and 1/cosθ at the Gauss points `[n_cells, 6]`, slope, dip, lift.
    """
    tangent = np.tan(terrain.gauss_theta)
    bends = _dip(terrain), _lift(terrain, curvature)
    return tangent, np.hypot(1.0, tangent), np.tan(terrain.theta), *bends


def build_cells(terrain: Terrain, resistance: Resistance) -> Cells:
    """Series of A and B in every cell (module docstring), with the geometry at its ends."""
    tangent, stretch, slope, dip, lift = _ground(terrain, float(resistance.curvature))
    turn = resistance.curvature * (terrain.theta[1:, None] - terrain.gauss_theta)
    left = terrain.s[1:, None] - terrain.gauss_s
    damped = terrain.weight * np.exp(-2.0 * resistance.drag[:, None] * left)
    pull = 2.0 * GRAVITY * tangent - 2.0 * resistance.constant[:, None] * stretch
    drive = np.zeros((terrain.n_cells, ORDER + 1))
    power = damped
    for k in range(ORDER):
        drive[:, k] += np.sum(power * pull, axis=1)
        drive[:, k + 1] -= 2.0 * GRAVITY * np.sum(power, axis=1)
        power = power * turn * (2.0 / (k + 1))
    drive[:, ORDER] += np.sum(power * pull, axis=1)

    length = np.diff(terrain.s)
    growth = np.empty((terrain.n_cells, ORDER + 1))
    growth[:, 0] = np.exp(-2.0 * resistance.drag * length)
    whole = resistance.curvature * np.diff(terrain.theta)
    for k in range(ORDER):
        growth[:, k + 1] = growth[:, k] * whole * (2.0 / (k + 1))

    # Tables at their neutral values must give the base model to the last bit.
    speed_resists = bool(np.any(resistance.speed_constant != 0.0))
    return Cells(
        x=terrain.x,
        y=terrain.y,
        slope=slope,
        steepening=terrain.bend * (1.0 + slope**2),
        bend=terrain.bend,
        growth=growth,
        drive=drive,
        dip=dip,
        lift=lift,
        length=length,
        speed_dependent=speed_resists or bool(np.any(resistance.speed_factor != 1.0)),
        speed_resists=speed_resists,
        **{name: getattr(resistance, name) for name in Resistance.__slots__},
    )


def _across(nodes: Floats, inside: Floats) -> Floats:
    """Values at start, Gauss points and end of each cell, `[n_cells, 8]`."""
    return np.column_stack([nodes[:-1], inside, nodes[1:]])


def _dip(terrain: Terrain) -> Floats:
    """A bound of how deep w can dip inside a cell that steepens; zero where it does not."""
    tangent = np.tan(_across(terrain.theta, terrain.gauss_theta))
    steepens = np.any(np.diff(tangent, axis=1) > 0.0, axis=1)
    spread = np.max(tangent, axis=1) - np.min(tangent, axis=1)
    return np.where(steepens, 2.5 * GRAVITY * spread * np.diff(terrain.x), 0.0)


def _lift(terrain: Terrain, curvature: float) -> Floats:
    """w below which the block stays on the ground all through a cell.

    N = 0 where w = g / (dθ/dx); a margin of 2 % covers places between the samples.
    """
    bend = curvature * _across(terrain.bend, terrain.gauss_bend)
    limit = np.full(bend.shape, np.inf)
    np.divide(GRAVITY, bend, out=limit, where=bend > 0.0)
    return np.asarray(0.98 * np.min(limit, axis=1))
