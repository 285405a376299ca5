"""A path on the map: places along its profile as points and pieces of a line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from pyproj import CRS

from avahazard.arrays import Floats
from avahazard.gis.systems import (
    WGS84,
    moved,
    profile_system,
    read_system,
    system_code,
)
from avahazard.records.path import Profile


@dataclass(frozen=True, slots=True, eq=False)
class PathLine:
    """Points `xy` `[n, 2]` (east before north) of `crs` at the places `x` (m) `[n]`.

    `code` names the system.
    """

    x: Floats
    y: Floats
    xy: Floats
    code: str
    crs: CRS

    @property
    def whole(self) -> shapely.LineString:
        """All of it."""
        return shapely.LineString(self.xy)

    def at(self, x: float) -> shapely.Point | None:
        """The point at a place x (m); None off the profile."""
        if not self.x[0] <= x <= self.x[-1]:
            return None
        return shapely.Point(self._point(x))

    def elevation(self, x: float) -> float:
        """Elevation (m) of the profile at a place x (m)."""
        return float(np.interp(x, self.x, self.y))

    def between(self, start: float, end: float) -> shapely.LineString | None:
        """The piece from one place to another (m), cut at the profile's ends; None if empty."""
        start, end = (float(np.clip(x, self.x[0], self.x[-1])) for x in (start, end))
        if end <= start:
            return None
        inside = self.xy[(self.x > start) & (self.x < end)]
        return shapely.LineString([self._point(start), *inside, self._point(end)])

    def strip(self, line: shapely.LineString, width: float) -> shapely.Geometry:
        """The ground within half the width (m) of a piece of it, straight at its ends."""
        metric = profile_system((self.crs,), moved(self.xy[:1], self.crs, WGS84)[0])
        there = moved_geometry(line, self.crs, metric)
        flat = shapely.buffer(there, width / 2.0, cap_style="flat", join_style="round")
        return moved_geometry(flat, metric, self.crs)

    def _point(self, x: float) -> Floats:
        return np.array([np.interp(x, self.x, coordinate) for coordinate in self.xy.T])


def path_line(profile: Profile) -> PathLine | str:
    """The line of a profile, or what its coordinates lack."""
    code = profile.crs or ""
    if profile.easting_m is not None and profile.northing_m is not None:
        xy = np.column_stack([profile.easting_m, profile.northing_m])
        crs = read_system(code)
        lacking = f"unknown crs '{code}'" if code else "coordinates without a crs"
    elif profile.lon is not None and profile.lat is not None:
        xy = np.column_stack([profile.lon, profile.lat])
        code, crs, lacking = "EPSG:4326", WGS84, ""
    else:
        return "no coordinates"
    if crs is None:
        return lacking
    return PathLine(profile.x_m, profile.y_m, xy, system_code(crs) or code, crs.to_2d())


def moved_geometry(geometry: shapely.Geometry, source: CRS, target: CRS) -> shapely.Geometry:
    """A geometry in another system."""
    return shapely.transform(geometry, lambda xy: moved(xy, source, target))
