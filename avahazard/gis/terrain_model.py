"""A terrain model (DEM): elevations between its cells, and the ground around a path."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import rasterio
from pyproj import CRS
from rasterio.enums import Resampling
from rasterio.errors import RasterioError
from rasterio.transform import from_origin, rowcol, xy
from rasterio.warp import reproject
from rasterio.windows import Window
from scipy.ndimage import map_coordinates

from avahazard.arrays import Bools, Floats
from avahazard.gis.systems import moved, read_system
from avahazard.records.collection import TerrainCrop
from avahazard.records.errors import AvahazardError

LOWEST_M, HIGHEST_M = -500.0, 9000.0
"""Beyond these a cell holds no elevation: a gap that the file does not declare, such as -9999."""
POINTS_A_READ = 32
MOST_CELLS = 400
MOST_HEADER = 10
"""Lines of the header of an ESRI ASCII grid."""
MARGIN_M, MARGIN_SHARE = 100.0, 0.1


@dataclass(frozen=True, slots=True, eq=False)
class TerrainModel:
    """An open terrain model in metres; `crs` is horizontal, `assumed` where the file has none."""

    file: str
    source: Any
    crs: CRS
    assumed: bool = False

    def grid_places(self, xy: Floats) -> tuple[Floats, Floats]:
        """Row and column `[n]` of points `[n, 2]` of its system, counted from cell centres."""
        row, column = rowcol(self.source.transform, xy[:, 0], xy[:, 1], op=np.asarray)
        return row - 0.5, column - 0.5

    def holds(self, xy: Floats) -> Bools:
        """Which points `[n, 2]` lie between the centres of four cells."""
        places, slack = np.array(self.grid_places(xy)), 1e-6
        last = np.array([[self.source.height], [self.source.width]]) - 1
        return np.asarray(np.all((places >= -slack) & (places <= last + slack), axis=0))

    def elevations(self, xy: Floats) -> Floats:
        """Elevations (m) `[n]` at points `[n, 2]`, linear between cell centres; NaN by a gap."""
        row, column = self.grid_places(xy)
        found = np.empty(len(xy))
        for start in range(0, len(xy), POINTS_A_READ):
            some = slice(start, start + POINTS_A_READ)
            found[some] = self._between(row[some], column[some])
        return found

    def _between(self, row: Floats, column: Floats) -> Floats:
        top, left = (max(0, int(np.floor(v.min()))) for v in (row, column))
        bottom = min(self.source.height, int(np.floor(row.max())) + 2)
        right = min(self.source.width, int(np.floor(column.max())) + 2)
        window = Window.from_slices((top, bottom), (left, right))
        cells = self.source.read(1, window=window, masked=True).astype(np.float64)
        places, values = np.array([row - top, column - left]), self._metres(cells.filled(np.nan))
        return np.asarray(map_coordinates(values, places, order=1, mode="nearest"), np.float64)

    def _metres(self, cells: Floats) -> Floats:
        cells = cells * self.source.scales[0] + self.source.offsets[0]
        with np.errstate(invalid="ignore"):
            return np.where((cells >= LOWEST_M) & (cells <= HIGHEST_M), cells, np.nan)

    def cell_size(self, near: Floats, crs: CRS) -> float:
        """Edge (m) of a cell near the point `[2]` of `crs`, a system in metres."""
        (row,), (column,) = self.grid_places(moved(near[None, :], crs, self.crs))
        rows, columns = row + np.array([0.0, 0.0, 1.0]), column + np.array([0.0, 1.0, 0.0])
        corners = np.column_stack(xy(self.source.transform, rows, columns))
        at, right, below = moved(corners, self.crs, crs)
        return float(np.sqrt(np.hypot(*(right - at)) * np.hypot(*(below - at))))

    def around(self, path_id: str, points: Floats, crs: CRS, name: str) -> TerrainCrop:
        """The ground around the `points` `[n, 2]` of a path, in `crs`, which `name` names."""
        low, high = points.min(axis=0), points.max(axis=0)
        margin = max(MARGIN_M, MARGIN_SHARE * float(np.max(high - low)))
        extent = high - low + 2.0 * margin
        own_cell = self.cell_size(points[0], crs)
        cell = max(own_cell, float(extent.max()) / MOST_CELLS)
        width, height = (int(n) for n in np.minimum(np.ceil(extent / cell), MOST_CELLS))
        west, north = float(low[0] - margin), float(high[1] + margin)
        cells = np.full((height, width), np.nan, np.float32)
        reproject(
            rasterio.band(self.source, 1),
            cells,
            src_crs=self.crs.to_wkt(),
            dst_transform=from_origin(west, north, cell, cell),
            dst_crs=crs.to_wkt(),
            dst_nodata=np.nan,
            resampling=Resampling.average if cell > 1.5 * own_cell else Resampling.bilinear,
        )
        elevation = self._metres(cells.astype(np.float64)).astype(np.float32)
        return TerrainCrop(path_id, name, west, north, cell, elevation)


@contextmanager
def open_terrain(file: FilePath, crs: CRS | None = None) -> Iterator[TerrainModel]:
    """Open a terrain model: GeoTIFF, ESRI ASCII grid, or what else GDAL reads.

    `crs` is the system of a file that does not name its own. Raises `AvahazardError` where it
    cannot be read, has no reference system, or is no model in metres.
    """
    if not file.is_file():
        raise AvahazardError(f"There is no file {file}.", "Name a terrain model with --dem.")
    try:
        with rasterio.open(_readable(file)) as source:
            system = _checked(file, source, crs)
            yield TerrainModel(str(file), source, system, assumed=not source.crs)
    except RasterioError as error:
        raise AvahazardError(
            f"The terrain model {file} cannot be read: {error}",
            "Give a GeoTIFF (.tif) or an ESRI ASCII grid (.asc).",
        ) from error


def _readable(file: FilePath) -> str:
    """What GDAL is to open: the file, or a description of a grid whose header it does not read.

    An ESRI ASCII grid with another number of values than its header says is refused.
    """
    header: dict[str, str] = {}
    if file.suffix.lower() not in (".asc", ".agr", ".txt"):
        return str(file)
    with file.open("rb") as lines:
        at = 0
        for line in lines:
            words = line.decode("latin-1").split()
            if len(words) != 2 or not words[0][0].isalpha() or len(header) > MOST_HEADER:
                break
            header[words[0].lower()] = words[1]
            at += len(line)
        if not {"ncols", "nrows"} <= header.keys():
            return str(file)
        lines.seek(at)
        n = sum(len(line.split()) for line in lines)
    columns, rows = header["ncols"], header["nrows"]
    if not (columns.isdigit() and rows.isdigit()):
        return str(file)
    if n != int(columns) * int(rows):
        raise AvahazardError(
            f"The header of {file} says {columns} columns and {rows} rows, "
            f"{int(columns) * int(rows)} values; the file has {n}.",
            "Correct ncols and nrows, or save the grid again from your GIS.",
        )
    if {"xllcenter", "yllcorner"} <= header.keys() or {"xllcorner", "yllcenter"} <= header.keys():
        return _described(file, header)
    return str(file)


def _described(file: FilePath, header: Mapping[str, str]) -> str:
    """A grid whose header gives the corner of one coordinate, the centre of the other."""
    try:
        cell = float(header["cellsize"])
        west, south = (
            float(header[f"{c}llcorner"])
            if f"{c}llcorner" in header
            else float(header[f"{c}llcenter"]) - cell / 2.0
            for c in "xy"
        )
    except (KeyError, ValueError):
        return str(file)
    east, north = west + int(header["ncols"]) * cell, south + int(header["nrows"]) * cell
    return f"vrt://{file.resolve()}?a_ullr={west},{north},{east},{south}"


def _has_cells(transform: rasterio.Affine) -> bool:
    """Whether a grid's place on the map is finite and its cells have an area."""
    area = transform.a * transform.e - transform.b * transform.d
    return bool(np.isfinite([*transform[:6], area]).all() and area != 0.0)


def _checked(file: FilePath, source: Any, given: CRS | None) -> CRS:
    crs = read_system(source.crs.to_wkt() if source.crs else None)
    if crs is not None and len(crs.axis_info) == 2:
        # GDAL knows by more than their names the systems that ESRI's files describe.
        crs = read_system(f"EPSG:{code}") if (code := source.crs.to_epsg()) else crs
    if crs is None and not (source.crs and source.crs.to_wkt()):
        crs = given
    if crs is None:
        raise AvahazardError(
            f"The terrain model {file} has no reference system.",
            f"Name it: --crs EPSG:31287. Or put {file.with_suffix('.prj').name} beside it, with "
            "the system's text, such as that "
            f"of `gdalsrsinfo -o wkt_esri EPSG:31287`; or save it as GeoTIFF with its system.",
        )
    if source.count != 1:
        raise AvahazardError(
            f"{file} has {source.count} bands: a picture, not a terrain model.",
            "Give a file with one band of elevations in metres.",
        )
    if not _has_cells(source.transform):
        raise AvahazardError(
            f"The terrain model {file} does not say where its cells lie, or how large they are.",
            "Save it again from your GIS; it may be damaged.",
        )
    heights = [axis.unit_conversion_factor for axis in crs.axis_info[2:]]
    unit = (source.units[0] or "").lower()
    if any(factor != 1.0 for factor in heights) or "f" in unit:
        raise AvahazardError(
            f"The elevations of {file} are not in metres.", "Convert them to metres first."
        )
    return crs.to_2d()
