"""A terrain model of an analytic surface, lines on it, and forest, written as files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyogrio
import rasterio
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]

WEST, NORTH, CODE = 255_000.0, 382_000.0, "EPSG:31287"
TOP, BOTTOM = (WEST + 1000.0, NORTH - 150.0), (WEST + 400.0, NORTH - 1350.0)


def surface(east: Any, north: Any) -> Any:
    """Elevation (m): falling to the south, ever flatter, with a bump across."""
    down = NORTH - north
    return 2400.0 - 0.9 * down + 2.2e-4 * down**2 + 15.0 * np.sin((east - WEST) / 180.0)


def write_dem(
    file: Path,
    cell: float = 10.0,
    width: int = 150,
    height: int = 160,
    crs: str | None = CODE,
    holes: tuple[tuple[int, int], ...] = (),
    **options: Any,
) -> Path:
    """Write the surface: what a cell holds is the elevation of its centre."""
    east = WEST + (np.arange(width) + 0.5) * cell
    north = NORTH - (np.arange(height) + 0.5) * cell
    values = surface(east[None, :], north[:, None]).astype(np.float32)
    for hole in holes:
        values[hole] = -9999.0
    profile = {
        "driver": "AAIGrid" if file.suffix == ".asc" else "GTiff",
        "width": width,
        "height": height,
        "count": 1,
        "dtype": "float32",
        "crs": crs,
        "transform": rasterio.Affine(cell, 0.0, WEST, 0.0, -cell, NORTH),
        "nodata": -9999.0,
    }
    with rasterio.open(file, "w", **(profile | options)) as target:
        target.write(values, 1)
    return file


def write_lines(
    file: Path,
    lines: list[Any],
    columns: dict[str, list[Any]],
    crs: str | None = CODE,
    layer: str | None = None,
    kind: str | None = None,
) -> Path:
    """Write lines (their corners, or geometries) with their attributes."""
    made = [
        line if line is None or isinstance(line, shapely.Geometry) else shapely.LineString(line)
        for line in lines
    ]
    kinds = {g.geom_type for g in made if g is not None}
    pyogrio.raw.write(
        file,
        geometry=shapely.to_wkb(np.array(made, dtype=object)),
        field_data=[
            np.array(v) if None not in v else np.array(v, object) for v in columns.values()
        ],
        fields=list(columns),
        geometry_type=kind or kinds.pop() if len(kinds) == 1 else "Unknown",
        crs=crs,
        layer=layer,
    )
    return file
