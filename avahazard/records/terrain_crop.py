"""The ground around a path, cut from a terrain model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class TerrainCrop:
    """Elevations `elevation_m` `[n_rows, n_columns]` float32, NaN where they are not known.

    Rows run from north to south, columns from west to east; the cells are squares of `cell_m`
    in `crs` (such as `EPSG:31287`), and `west_m`, `north_m` is the outer corner of the first.
    """

    path_id: str
    crs: str
    west_m: float
    north_m: float
    cell_m: float
    elevation_m: NDArray[np.float32]
