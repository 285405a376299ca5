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


def filled_table(coarse: RunoutTable, step: int) -> RunoutTable:
    """The table over `MU` from one over every `step`-th of it: linear between like neighbours.

    Across a change of status the nearer neighbour counts.
    """
    place = np.minimum(np.arange(len(MU)) / step, coarse.x.shape[1] - 1.0)
    j = np.minimum(place.astype(int), coarse.x.shape[1] - 2)
    share = place - j
    alike = coarse.status[:, j] == coarse.status[:, j + 1]
    share = np.where(alike, share, np.round(share))
    nearest = np.where(share >= 0.5, j + 1, j)
    rows = np.arange(len(coarse.x))[:, None]

    def between(values: Floats) -> Floats:
        # Not a plain sum of shares: nan of the neighbour must not spill over.
        exact = values[rows, nearest]
        mixed = values[:, j] * (1.0 - share) + values[:, j + 1] * share
        return np.where(alike, mixed, exact)

    return RunoutTable(
        x=between(coarse.x), y=between(coarse.y), status=coarse.status[rows, nearest]
    )
