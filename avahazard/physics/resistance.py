"""What resists the block besides plain Coulomb friction: filled in by effects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.terrain import Terrain

GRAVITY = 9.81
"""Acceleration of gravity, m/s²."""


SPEED_STEP = 0.5
"""Spacing of the tables over speed, m/s."""
SPEEDS = np.arange(0.0, 150.0 + SPEED_STEP, SPEED_STEP)
"""Speeds at which effects that depend on speed are tabulated, m/s `[n_speeds]`."""


@dataclass(frozen=True, slots=True, eq=False)
class Resistance:
    """Resisting force per mass in each cell: m(x) s(u) μ N + o(x) N + c(x) + r(u) + d(x) u².

    `factor` m and `offset` o change the friction, `constant` c is in m/s², `drag` d in 1/m, all
    `[n_cells]`; `speed_factor` s and `speed_constant` r (m/s²) are tabulated at `SPEEDS`, None
    where friction does not depend on speed. `curvature` scales the centrifugal load (1, or 0
    where it is left out).
    """

    factor: Floats
    offset: Floats
    constant: Floats
    drag: Floats
    curvature: float = 1.0
    speed_factor: Floats | None = None
    speed_constant: Floats | None = None


def no_resistance(terrain: Terrain) -> Resistance:
    """The base model: Coulomb friction alone."""
    n = terrain.n_cells
    return Resistance(np.ones(n), np.zeros(n), np.zeros(n), np.zeros(n))
