"""Folders as AvaFrame has them: terrain, release area, line and settings; and the peaks it leaves.

A stop along a line is AIMEC's: the farthest place across from which, within `HALF_WIDTH_M` of the
line, peak pressure exceeds `STOP_KPA`.
"""

from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import NamedTuple

import numpy as np
import pyogrio
import rasterio
import shapely
from numpy.typing import NDArray
from pyproj import CRS

from avahazard.arrays import Floats
from avahazard.gis.hazard_map import PathLine
from avahazard.gis.systems import along, cells_of, moved, moved_geometry
from avahazard.gis.vector_layer import read_layer
from avahazard.records.collection import TerrainCrop

STOP_KPA, HALF_WIDTH_M = 1.0, 250.0
SLAB_M, LONGEST_SHARE, LEAST_CELLS = 1.0, 0.2, 3
"""Thickness of the slab that a made release area has, normal to the slope, as long as it is no
longer than that share of the path; and the fewest cells of its sides."""
NO_DATA = -9999.0


class Ground(NamedTuple):
    """A path in the cells of its terrain.

    `xy` `[n, 2]` are points of its line in the system of `crop`, at places `x` (m) `[n]`; `place`
    `[n_rows, n_columns]` is the place x (m) along the line of each cell, nan far from the line.
    """

    crop: TerrainCrop
    x: Floats
    xy: Floats
    place: Floats


def ground(line: PathLine, crop: TerrainCrop) -> Ground:
    """The line of a path laid on its terrain."""
    xy = moved(line.xy, line.crs, CRS.from_user_input(crop.crs))
    middles = rasterio.transform.xy(cells_of(crop), *np.indices(crop.elevation_m.shape))
    points = shapely.points(*middles).reshape(crop.elevation_m.shape)
    whole = shapely.LineString(xy)
    far = shapely.distance(points, whole) > HALF_WIDTH_M
    place = np.interp(shapely.line_locate_point(whole, points), along(xy), line.x)
    return Ground(crop, line.x, xy, np.where(far, np.nan, place))


def stop_of(ground: Ground, peak_kpa: NDArray[np.float32]) -> float:
    """The farthest place (m) along the line with a peak pressure over `STOP_KPA`; nan for none."""
    hit = (peak_kpa > STOP_KPA) & np.isfinite(ground.place)
    return float(np.max(ground.place[hit])) if hit.any() else np.nan


def made_release(ground: Ground, release_x: float, width_m: float, volume_m3: float) -> Floats:
    """Corners `[4, 2]` of a release area about a place (m), as wide as the flow, `SLAB_M` thick."""
    cell = ground.crop.cell_m
    slope = _steepness(ground, release_x)
    width = max(width_m, LEAST_CELLS * cell)
    longest = LONGEST_SHARE * float(ground.x[-1] - ground.x[0])
    length = np.clip(volume_m3 / (SLAB_M * width) * np.cos(slope), LEAST_CELLS * cell, longest)
    start = max(release_x - 0.5 * length, float(ground.x[0]))
    ends = np.column_stack([np.interp((start, start + length), ground.x, c) for c in ground.xy.T])
    ahead = (ends[1] - ends[0]) / max(float(np.hypot(*(ends[1] - ends[0]))), 1e-9)
    side = 0.5 * width * np.array([-ahead[1], ahead[0]])
    return np.array([ends[0] + side, ends[1] + side, ends[1] - side, ends[0] - side])


def drawn_release(file: FilePath, ground: Ground) -> Floats | None:
    """Corners `[n, 2]` of the largest polygon of a file that the line crosses; None for none."""
    layer, whole = read_layer(file, "polygon"), shapely.LineString(ground.xy)
    there = CRS.from_user_input(ground.crop.crs)
    areas = [moved_geometry(shapely.make_valid(a), layer.crs, there) for a in layer.geometry if a]
    areas = [a for a in areas if a.geom_type == "Polygon" and a.intersects(whole)]
    if not areas:
        return None
    return np.asarray(max(areas, key=lambda a: a.area).exterior.coords)[:-1, :2]


def thickness_of(ground: Ground, corners: Floats, volume_m3: float) -> float:
    """Thickness (m), normal to the slope, of a volume on a release area."""
    area = shapely.Polygon(corners)
    middle = shapely.LineString(ground.xy).project(area.centroid)
    slope = _steepness(ground, float(np.interp(middle, ground.x - ground.x[0], ground.x)))
    return float(volume_m3 * np.cos(slope) / area.area)


def _steepness(ground: Ground, x: float) -> float:
    """Slope angle of the terrain about a place (m) of the line."""
    crop = ground.crop
    reach = 3.0 * crop.cell_m
    ends = np.clip([x - reach, x + reach], ground.x[0], ground.x[-1])
    east, north = (np.interp(ends, ground.x, c) for c in ground.xy.T)
    place = np.array([crop.north_m - north, east - crop.west_m]) / crop.cell_m
    last = np.array(crop.elevation_m.shape)[:, None] - 1
    upper, lower = crop.elevation_m[*np.clip(place, 0, last).astype(int)].astype(float)
    return float(np.arctan2(max(upper - lower, 0.0), ends[1] - ends[0]))


def write_project(
    folder: FilePath, ground: Ground, corners: Floats, settings: Mapping[str, object]
) -> None:
    """Write a folder that com1DFA runs as it is; `settings` are those of its section GENERAL."""
    crop = ground.crop
    inputs = folder / "Inputs"
    for name in ("REL", "LINES", "CFGs"):
        (inputs / name).mkdir(parents=True, exist_ok=True)
    n_rows, n_columns = crop.elevation_m.shape
    with rasterio.open(
        inputs / "dem.tif", "w", driver="GTiff", height=n_rows, width=n_columns, count=1,
        dtype="float32", crs=crop.crs, transform=cells_of(crop), nodata=NO_DATA,
    ) as file:  # fmt: skip
        file.write(np.where(np.isfinite(crop.elevation_m), crop.elevation_m, NO_DATA), 1)
    _write_shape(inputs / "LINES" / "path_aimec.shp", shapely.LineString(ground.xy), crop.crs)
    write_scenario(folder, crop.crs, corners, settings, "release", "Inputs/CFGs/com1DFACfg.ini")


def write_scenario(
    folder: FilePath, crs: str, corners: Floats, settings: Mapping[str, object], name: str, ini: str
) -> None:
    """Write the release `name` of a project, and the settings in `ini` that run only this one."""
    _write_shape(folder / "Inputs" / "REL" / f"{name}.shp", shapely.Polygon(corners), crs)
    lines = ["[GENERAL]", *(f"{key} = {value}" for key, value in settings.items())]
    lines += ["", "[INPUT]", f"releaseScenario = {name}"]
    (folder / ini).write_text("\n".join(lines) + "\n", encoding="utf-8")


def _write_shape(file: FilePath, geometry: shapely.Geometry, crs: str) -> None:
    pyogrio.raw.write(
        file,
        shapely.to_wkb(np.array([geometry])),
        [np.array([file.stem], dtype=object)],
        ["name"],
        geometry_type=geometry.geom_type,
        crs=crs,
        driver="ESRI Shapefile",
    )


def read_peak(folder: FilePath, crop: TerrainCrop) -> NDArray[np.float32] | None:
    """Peak pressures (kPa) that com1DFA left, in the cells of the terrain; None without such."""
    files = sorted((folder / "Outputs" / "com1DFA" / "peakFiles").glob("*_ppr.*"))
    files = [f for f in files if f.suffix.lower() in (".asc", ".tif")]
    if len(files) != 1:
        return None
    with rasterio.open(files[0]) as source:
        peak = source.read(1, masked=True).filled(0.0).astype(np.float32)
    return peak if peak.shape == crop.elevation_m.shape else None
