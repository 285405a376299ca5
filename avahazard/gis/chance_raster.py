"""Annual chances as a raster and as areas: cloud-optimised GeoTIFF, polygons of a GeoPackage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import NamedTuple

import numpy as np
import rasterio
import shapely
from numpy.typing import NDArray
from pyproj import CRS
from rasterio.enums import Resampling
from rasterio.errors import RasterioError
from rasterio.features import rasterize, shapes
from rasterio.warp import reproject

from avahazard.arrays import Floats
from avahazard.gis.hazard_map import Feature, MappedPath, PathLine, moved_geometry
from avahazard.records.collection import TerrainCrop
from avahazard.records.errors import AvahazardError

OWNER = "avahazard"
MOST_CELLS = 200_000_000


class MapGrid(NamedTuple):
    """Cells of a map: squares of `cell_m`, north up, from the corner `west_m`, `north_m`."""

    crs: str
    west_m: float
    north_m: float
    cell_m: float
    n_rows: int
    n_columns: int

    @property
    def transform(self) -> rasterio.Affine:
        """From columns and rows to the map."""
        return _transform(self.west_m, self.north_m, self.cell_m)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.n_rows, self.n_columns


def _transform(west: float, north: float, cell: float) -> rasterio.Affine:
    return rasterio.Affine(cell, 0.0, west, 0.0, -cell, north)


def grid_of(crops: Sequence[TerrainCrop]) -> MapGrid:
    """The cells that hold the ground of all paths, as fine as the finest of them.

    Raises:
        AvahazardError: the paths are in several systems, or too far apart for one map.
    """
    systems = sorted({crop.crs for crop in crops})
    if len(systems) > 1:
        raise AvahazardError(
            f"The terrain of these paths is in several systems: {', '.join(systems)}.",
            "Draw a map of those in one system: --path PATH, again for each.",
        )
    cell = min(crop.cell_m for crop in crops)
    west, north = min(c.west_m for c in crops), max(c.north_m for c in crops)
    ends = [
        (
            c.west_m + c.cell_m * c.elevation_m.shape[1],
            c.north_m - c.cell_m * c.elevation_m.shape[0],
        )
        for c in crops
    ]
    n_columns = int(np.ceil((max(east for east, _ in ends) - west) / cell - 1e-6))
    n_rows = int(np.ceil((north - min(south for _, south in ends)) / cell - 1e-6))
    if n_rows * n_columns > MOST_CELLS:
        raise AvahazardError(
            f"A map of all these paths would have {n_rows} times {n_columns} cells.",
            "Draw several maps: --path PATH, again for each path of one.",
        )
    return MapGrid(systems[0], west, north, cell, n_rows, n_columns)


def on_grid(grid: MapGrid, crop: TerrainCrop, values: Floats) -> NDArray[np.float32]:
    """Values in the cells of a path's ground, laid on the map; NaN elsewhere."""
    found = np.full(grid.shape, np.nan, np.float32)
    reproject(
        values.reshape(crop.elevation_m.shape).astype(np.float32),
        found,
        src_transform=_transform(crop.west_m, crop.north_m, crop.cell_m),
        dst_transform=grid.transform,
        src_crs=crop.crs,
        dst_crs=grid.crs,
        src_nodata=np.nan,
        dst_nodata=np.nan,
        resampling=Resampling.nearest,
    )
    return found


def strip_on_grid(
    grid: MapGrid, one: MappedPath, x: Floats, chance: Floats, width_m: float
) -> NDArray[np.float32]:
    """Chances `[n]` at places x (m) along a path's line, over the width of the flow; else NaN."""
    pieces = []
    for start, end, value in zip(x[:-1], x[1:], chance[1:], strict=True):
        piece = one.line.between(float(start), float(end))
        if piece is not None:
            area = one.line.strip(piece, width_m)
            pieces.append(
                (moved_geometry(area, one.line.crs, CRS.from_user_input(grid.crs)), value)
            )
    if not pieces:
        return np.full(grid.shape, np.nan, np.float32)
    return np.asarray(
        rasterize(pieces, grid.shape, fill=np.nan, transform=grid.transform, dtype="float32")
    )


def write_raster(file: FilePath, grid: MapGrid, bands: Mapping[str, NDArray[np.float32]]) -> None:
    """Write the new file as a cloud-optimised GeoTIFF; NaN is no data, bands have their names.

    Raises:
        AvahazardError: it cannot be written.
    """
    try:
        with rasterio.open(
            file, "w", driver="COG", height=grid.n_rows, width=grid.n_columns, count=len(bands),
            dtype="float32", crs=grid.crs, transform=grid.transform, nodata=np.nan,
            compress="deflate",
        ) as target:  # fmt: skip
            for k, (name, values) in enumerate(bands.items(), 1):
                target.write(values, k)
                target.set_band_description(k, name)
            target.update_tags(software=OWNER)
    except RasterioError as error:
        raise AvahazardError(
            f"{file} cannot be written: {error}", "Name a file in another folder."
        ) from error


def is_own_raster(file: FilePath) -> bool:
    """Whether `file` was made by `write_raster`."""
    try:
        with rasterio.open(file) as source:
            return bool(source.tags().get("software") == OWNER)
    except RasterioError:
        return False


def areas(
    grid: MapGrid, inside: NDArray[np.bool_], line: PathLine, attributes: Mapping[str, object]
) -> list[Feature]:
    """The cells `inside` as polygons in the system of a path's line, each with the attributes."""
    there = CRS.from_user_input(grid.crs)
    found = shapes(inside.astype(np.uint8), mask=inside, transform=grid.transform)
    return [
        Feature(
            line, moved_geometry(shapely.geometry.shape(shape), there, line.crs), dict(attributes)
        )
        for shape, _ in found
    ]
