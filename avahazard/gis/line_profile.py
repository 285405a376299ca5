"""The profile of a path from its line on a map and a terrain model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np
import shapely
from pyproj import CRS

from avahazard.arrays import Floats
from avahazard.gis.land_cover import cover_at
from avahazard.gis.systems import WGS84, moved, profile_system, system_code
from avahazard.gis.terrain_model import TerrainModel
from avahazard.records.terrain_crop import TerrainCrop

FEWEST_STEPS, MOST_STEPS = 50, 400


class LineFault(Exception):  # noqa: N818
    """What is wrong with a line, and what would be accepted in its place."""

    def __init__(self, value: str, accepted: str) -> None:
        super().__init__(value)
        self.value = value
        self.accepted = accepted


@dataclass(frozen=True, slots=True, eq=False)
class LineProfile:
    """Points from the top: `x`, `y`, `easting`, `northing` in m, `[n]` each, and land cover."""

    x: Floats
    y: Floats
    easting: Floats
    northing: Floats
    crs: str
    cover: tuple[str, ...] | None
    terrain: TerrainCrop


def line_profile(
    path_id: str,
    geometry: shapely.Geometry | None,
    crs: CRS,
    terrain: TerrainModel,
    land_cover: FilePath | None = None,
) -> LineProfile:
    """Sample `terrain` along a line drawn from the top of a path in `crs`.

    Steps are as long as a cell of the terrain model, but 50 to 400 along the line; its corners
    are points too, unless they are over 400. x is the horizontal distance along the points.

    Raises:
        LineFault: the line is none, leaves the terrain model or crosses a gap in it, or runs
            uphill.
        AvahazardError: the land cover cannot be used.
    """
    corners = _corners(geometry)
    lonlat = moved(corners[:1], crs, WGS84)[0]
    if not np.all(np.isfinite(moved(corners, crs, terrain.crs))):
        raise LineFault(f"outside {crs.name}", f"coordinates of {crs.name}")
    system = profile_system((terrain.crs, crs), lonlat)
    xy = _densified(moved(corners, crs, system), terrain, system)
    x = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))])
    y = _sampled(x, xy, crs, system, terrain)
    if y[0] <= y[-1]:
        raise LineFault(
            f"starts at {y[0]:.0f} m above the sea, ends at {y[-1]:.0f} m",
            "a line that runs down: draw it from the top of the path",
        )
    name = system_code(system)
    assert name is not None
    return LineProfile(
        x,
        y,
        xy[:, 0],
        xy[:, 1],
        name,
        None if land_cover is None else cover_at(land_cover, xy, system),
        terrain.around(path_id, xy, system, name),
    )


def _corners(geometry: shapely.Geometry | None) -> Floats:
    """The corners of a line `[n, 2]`, none of them twice in a row."""
    if geometry is None or geometry.is_empty:
        raise LineFault("no geometry that can be read", "a line")
    if geometry.geom_type == "MultiLineString":
        if len(geometry.geoms) != 1:
            raise LineFault(
                f"a line of {len(geometry.geoms)} parts", "one line: join its parts, from the top"
            )
        geometry = geometry.geoms[0]
    if geometry.geom_type != "LineString":
        raise LineFault(f"a {geometry.geom_type}", "a line")
    xy = shapely.get_coordinates(geometry)
    moves = np.concatenate([[True], np.any(np.diff(xy, axis=0) != 0.0, axis=1)])
    if np.count_nonzero(moves) < 2:
        raise LineFault("a line with one point", "a line with at least 2 points")
    return np.asarray(xy[moves], np.float64)


def _densified(xy: Floats, terrain: TerrainModel, system: CRS) -> Floats:
    line = shapely.LineString(xy)
    cell = terrain.cell_size(xy[0], system)
    if not (np.isfinite(cell) and cell > 0.0):
        raise LineFault("a line where the terrain model has no cells", "a line on it")
    n_steps = int(np.clip(np.ceil(line.length / cell), FEWEST_STEPS, MOST_STEPS))
    if len(xy) <= MOST_STEPS:
        # A hair longer, or rounding would cut a straight line into one step more.
        line = shapely.segmentize(line, line.length / n_steps * (1.0 + 1e-9))
        return np.asarray(shapely.get_coordinates(line), np.float64)
    places = np.linspace(0.0, line.length, n_steps + 1)
    return np.asarray(shapely.get_coordinates(shapely.line_interpolate_point(line, places)))


def _sampled(x: Floats, xy: Floats, crs: CRS, system: CRS, terrain: TerrainModel) -> Floats:
    there = moved(xy, system, terrain.crs)
    held = terrain.holds(there)
    if not held.any():
        raise LineFault(
            f"nowhere on {terrain.file}: its top is at {_shown(there[0])} in the system of the "
            f"terrain model ({terrain.crs.name})",
            f"a line on the terrain model, whose cells cover {_shown_bounds(terrain)}; the line "
            f"says that it is in {crs.name}",
        )
    if not held.all():
        k = int(np.argmin(held))
        raise LineFault(
            f"{_place(x, xy, k)}: outside {terrain.file}",
            "a line inside the terrain model, half a cell from its edge at least",
        )
    y = terrain.elevations(there)
    gaps = np.isnan(y)
    if gaps.any():
        k = int(np.argmax(gaps))
        raise LineFault(
            f"{_place(x, xy, k)}: no elevation in {terrain.file}",
            f"elevations at all points: {np.count_nonzero(gaps)} of {len(y)} are missing",
        )
    return y


def _place(x: Floats, xy: Floats, k: int) -> str:
    return f"at {x[k]:.0f} m from its top ({_shown(xy[k])})"


def _shown(point: Floats) -> str:
    digits = 5 if np.all(np.abs(point) <= 360.0) else 0
    return f"{point[0]:.{digits}f} E, {point[1]:.{digits}f} N"


def _shown_bounds(terrain: TerrainModel) -> str:
    west, south, east, north = terrain.source.bounds
    return f"{_shown(np.array([west, south]))} to {_shown(np.array([east, north]))}"
