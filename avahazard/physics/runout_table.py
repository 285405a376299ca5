"""F(μ): where the block stops as a function of friction, tabulated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.physics.block import LEFT_PROFILE, NOT_RELEASED, run
from avahazard.physics.cells import Cells

Floats = NDArray[np.float64]

MU_STEP = 0.0025
"""Spacing of the friction grid, as in the paper."""
MU = np.arange(0.02, 1.6 + MU_STEP / 2, MU_STEP)
"""Frictions at which runouts are tabulated, `[n_friction]`."""


@dataclass(frozen=True, slots=True, eq=False)
class RunoutTable:
    """F(μ) from several releases on one path; arrays `[n_starts, n_friction]` over `MU`.

    Where the block left the profile, `x` and `y` are nan; where it was not released, they are
    the release (`block.Stops`).
    """

    x: Floats
    y: Floats
    status: NDArray[np.int8]

    @property
    def left(self) -> NDArray[np.bool_]:
        """Whether the block left the profile."""
        return np.asarray(self.status == LEFT_PROFILE)

    @property
    def not_released(self) -> NDArray[np.bool_]:
        """Whether the block was held at its release."""
        return np.asarray(self.status == NOT_RELEASED)


def runout_table(cells: Cells, starts: NDArray[np.int64], mu: Floats = MU) -> RunoutTable:
    """Tabulate F(μ) for each start node `[n_starts]` over the frictions `mu` `[n_friction]`."""
    stops = run(cells, starts, mu)
    return RunoutTable(x=stops.x, y=stops.y, status=stops.status)
