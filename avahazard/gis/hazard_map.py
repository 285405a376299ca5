"""The map of a model's results: paths, releases, runouts, zones and recorded stops."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

import numpy as np
import shapely
from pyproj import CRS

from avahazard.arrays import Floats
from avahazard.gis.systems import (
    WGS84,
    moved,
    moved_geometry,
    profile_system,
    read_system,
    system_code,
)
from avahazard.notes import ENGLISH
from avahazard.records.collection import Event, Path, Profile
from avahazard.results.hazard import HazardRow, PlaceQuantiles, Spread, ZonedPath


@dataclass(frozen=True, slots=True, eq=False)
class PathLine:
    """Points `xy` `[n, 2]` (east, north) of `crs`, named `code`, at the places `x` (m) `[n]`."""

    x: Floats
    y: Floats
    xy: Floats
    code: str
    crs: CRS

    def at(self, x: float) -> shapely.Point | None:
        """The point at a place x (m); None off the profile."""
        if not self.x[0] <= x <= self.x[-1]:
            return None
        return shapely.Point(self._point(x))

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
    if profile.on_map is None:
        return "no coordinates"
    xy, code = profile.on_map
    crs = read_system(code)
    if crs is None:
        return f"unknown crs '{code}'" if code else "coordinates without a crs"
    return PathLine(profile.x_m, profile.y_m, xy, system_code(crs) or code, crs.to_2d())


Kind = Literal["Point", "LineString", "Polygon"]


@dataclass(frozen=True, slots=True, eq=False)
class Feature:
    """A geometry in the system of `line`, with its attributes: text, numbers, flags or None."""

    line: PathLine
    geometry: shapely.Geometry
    attributes: dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class MapLayer:
    """Features that all have the same attributes; `topic` is its name without a system."""

    name: str
    topic: str
    kind: Kind
    features: tuple[Feature, ...]

    @property
    def code(self) -> str:
        """The system of its features."""
        return self.features[0].line.code


def layers_by_system(topic: str, kind: Kind, features: Sequence[Feature]) -> list[MapLayer]:
    """A layer for each system that the features are in: `paths`, or `paths_31287` of several."""
    by_code: dict[str, list[Feature]] = {}
    for feature in features:
        by_code.setdefault(feature.line.code, []).append(feature)
    layers = [MapLayer(topic, topic, kind, tuple(some)) for some in by_code.values()]
    if len(layers) == 1:
        return layers
    codes = [re.sub(r"\W+", "_", layer.code.lower().removeprefix("epsg:")) for layer in layers]
    return [replace(layer, name=f"{topic}_{k}") for layer, k in zip(layers, codes, strict=True)]


QUANTILES = ("q05", "q50", "q95")
WIDTH = "width_m"


@dataclass(frozen=True, slots=True, eq=False)
class MappedPath:
    """A path on the map: the places (m) of its release and of the recorded stops on it."""

    path: Path
    line: PathLine
    release_x: float
    stops: tuple[tuple[Event, float], ...]

    @property
    def width_m(self) -> float | None:
        """Width of the flow where the path has one: a further column of its."""
        width = self.path.covariates.get(WIDTH)
        return float(width) if isinstance(width, int | float) and width > 0 else None


def hazard_layers(
    drawn: Sequence[MappedPath], rows: Sequence[HazardRow], zones: Sequence[ZonedPath]
) -> list[MapLayer]:
    """The layers of the results on the paths `drawn`, without those that have no features."""
    by_path = {one.path.path_id: one for one in drawn}
    on_map = [(d, row) for row in rows if (d := by_path.get(row.path_id))]
    of_volume = [feature for one, row in on_map for feature in _of_volume(one, row)]
    design = [feature for one, row in on_map for feature in _design(one, row)]
    pieces = [f for zone in zones if (d := by_path.get(zone.path_id)) for f in _zones(d, zone)]
    areas = [
        Feature(f.line, f.line.strip(f.geometry, width), {**f.attributes, WIDTH: width})
        for f in pieces
        if (width := by_path[f.attributes["path_id"]].width_m) is not None
    ]
    releases = [
        f for d in drawn for f in _point(d.line, d.release_x, {"path_id": d.path.path_id}, {})
    ]
    return [
        *layers_by_system("zone_areas", "Polygon", areas),
        *layers_by_system("paths", "LineString", [_path(one) for one in drawn]),
        *layers_by_system("zones", "LineString", pieces),
        *layers_by_system("releases", "Point", releases),
        *layers_by_system("events", "Point", [f for one in drawn for f in _stops(one)]),
        *layers_by_system("volume_runouts", "Point", of_volume),
        *layers_by_system("design_runouts", "Point", design),
    ]


OF_PATH = [f.name for f in fields(Path) if f.name != "covariates"]


def _path(one: MappedPath) -> Feature:
    path, line = one.path, one.line
    recorded = {name: getattr(path, name) for name in OF_PATH}
    length, drop = float(line.x[-1] - line.x[0]), float(line.y[0] - line.y[-1])
    further = {WIDTH: one.width_m, "length_m": length, "drop_m": drop}
    return Feature(line, shapely.LineString(line.xy), {**recorded, **further})


def _point(
    line: PathLine, x: float | None, before: Mapping[str, Any], after: Mapping[str, Any]
) -> list[Feature]:
    """A point at a place x (m), its place among its attributes; none off the profile."""
    point = None if x is None else line.at(x)
    if x is None or point is None:
        return []
    place = {"x_m": float(x), "elevation_m": float(np.interp(x, line.x, line.y))}
    return [Feature(line, point, {**before, **place, **after})]


def _stops(one: MappedPath) -> list[Feature]:
    names = ("event_id", "path_id", "date", "volume_m3")
    features = []
    for event, x in one.stops:
        about = {name: getattr(event, name) for name in names}
        features += _point(one.line, x, about, {"sigma_m": event.runout_sigma_m})
    return features


def _of_volume(one: MappedPath, row: HazardRow) -> list[Feature]:
    """The quantiles of the runout of avalanches of the row's volume."""
    more = {"p_left_profile": row.p_left_profile, "interval": str(row.interval)}
    return _quantiles(one, row, row.runout_x_m, more)


def _design(one: MappedPath, row: HazardRow) -> list[Feature]:
    """The quantiles of the design runout; nothing for a volume."""
    found = row.design
    if found is None:
        return []
    farthest = found.farthest_record
    more = {
        "p_beyond": found.p_beyond,
        "farthest_record_x_m": farthest and farthest.runout_x_m,
        "farthest_record_date": farthest and farthest.date,
        "records_beyond": found.records_beyond,
        "n_records": found.n_records,
        "interval": str(found.interval),
    }
    return _quantiles(one, row, found.runout_x_m, more)


def _quantiles(
    one: MappedPath, row: HazardRow, found: Spread | PlaceQuantiles, more: Mapping[str, Any]
) -> list[Feature]:
    """A point for each quantile of x on the profile; `more` are further attributes."""
    about = {name: getattr(row, name) for name in ("path_id", "return_period_years", "volume_m3")}
    after = {f"x_{name}_m": getattr(found, name) for name in QUANTILES}
    after |= {
        "extrapolated": bool(row.extrapolated),
        **more,
        "notes": " ".join(map(ENGLISH.alone, row.notes)),
    }
    return [
        feature
        for name in QUANTILES
        for feature in _point(one.line, getattr(found, name), {**about, "quantile": name}, after)
    ]


OF_ZONE = ("extrapolated", "zone", "color", "from_x_m", "to_x_m", "to_x_q05_m", "to_x_q95_m")


def _zones(one: MappedPath, entry: ZonedPath) -> list[Feature]:
    about = {"path_id": entry.path_id, "limits": entry.limits}
    features = []
    for zone in entry.zones:
        piece = one.line.between(zone.from_x_m, zone.to_x_m)
        if piece is not None:
            of_zone = {name: getattr(zone, name) for name in OF_ZONE}
            attributes = {**about, **of_zone, "beyond_profile": zone.beyond}
            features.append(Feature(one.line, piece, attributes))
    return features
