"""An avalanche path and the points of its profile."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats

Covariate = float | str


@dataclass(frozen=True, slots=True)
class Path:
    """What is known of a path apart from its profile (docs/data_forms.md)."""

    path_id: str
    name: str | None = None
    location: str | None = None
    orientation: str | None = None
    section: str | None = None
    catchment_ha: float | None = None
    release_elevation_m: float | None = None
    observed_from: int | None = None
    observed_to: int | None = None
    observed_below_m: float | None = None
    covariates: Mapping[str, Covariate] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """Points along a path: `x_m` rises strictly from the top, all arrays `[n_points]`.

    `elevation_sigma_m` is the error of each elevation, one standard deviation, None where it is
    not known. Coordinates are either `easting_m`, `northing_m` in `crs`, or `lon`, `lat`, or
    absent.
    """

    path_id: str
    x_m: Floats
    y_m: Floats
    land_cover: tuple[str, ...] | None = None
    easting_m: Floats | None = None
    northing_m: Floats | None = None
    crs: str | None = None
    lon: Floats | None = None
    lat: Floats | None = None
    elevation_sigma_m: Floats | None = None


NUMBERS_OF_POINTS = ("x_m", "y_m", "easting_m", "northing_m", "lon", "lat", "elevation_sigma_m")
"""The arrays of a profile."""


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
