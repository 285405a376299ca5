"""Files of lines, one line a path, made into rows of paths and profiles on a terrain model."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import shapely
from pyproj import CRS

from avahazard.arrays import Floats
from avahazard.gis.systems import (
    WGS84,
    along,
    moved,
    moved_geometry,
    profile_system,
    read_system,
    system_code,
)
from avahazard.gis.terrain_model import TerrainModel, open_terrain
from avahazard.gis.vector_layer import VectorLayer, cover_at, read_layer
from avahazard.records.collection import Profile, TerrainCrop
from avahazard.records.errors import AvahazardError, RowProblem
from avahazard.records.intake import Drawn
from avahazard.records.meanings import known_name
from avahazard.records.rows import PathRow
from avahazard.records.table import FileTable, table_of

FEWEST_STEPS, MOST_STEPS = 50, 400
SHORTEST_M = 1e-6
MOST_TURN = 150.0
"""Degrees by which a line may turn at a corner."""
LEAST_STEP_M, STEEPEST = 150.0, 5.0
"""A step over this height and slope, beside flat ground, is an error of the terrain model."""


class LineFault(Exception):  # noqa: N818
    """What is wrong with a line, and what would be accepted in its place: its two arguments."""


def line_profile(
    path_id: str,
    geometry: shapely.Geometry | None,
    crs: CRS,
    terrain: TerrainModel,
    land_cover: FilePath | None = None,
) -> tuple[Profile, TerrainCrop]:
    """Sample `terrain` along a line drawn from the top of a path in `crs`, and around it.

    Steps are as long as a cell of the terrain model, but 50 to 400 along the line; its corners
    are points too, unless they are over 400. x is the horizontal distance along the points.
    Raises `LineFault` where the line is none, leaves the terrain model or crosses a gap in it, or
    runs uphill, and `AvahazardError` where the land cover cannot be used.
    """
    corners = _corners(geometry)
    lonlat = moved(corners[:1], crs, WGS84)[0]
    if not np.all(np.isfinite(moved(corners, crs, terrain.crs))):
        raise LineFault(f"outside {crs.name}", f"coordinates of {crs.name}")
    system = profile_system((terrain.crs, crs), lonlat)
    _check_course(moved(corners, crs, system))
    xy = _densified(moved(corners, crs, system), terrain, system)
    x = along(xy)
    y = _sampled(x, xy, crs, system, terrain)
    _check_voids(x, xy, y)
    if y[0] <= y[-1]:
        raise LineFault(
            f"starts at {y[0]:.0f} m above the sea, ends at {y[-1]:.0f} m",
            "a line that runs down: draw it from the top of the path",
        )
    name = system_code(system)
    assert name is not None
    cover = None if land_cover is None else cover_at(land_cover, xy, system)
    east, north = xy.T
    profile = Profile(path_id, x, y, cover, east, north, name)
    return profile, terrain.around(path_id, xy, system, name)


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


def _check_course(xy: Floats) -> None:
    """Refuse a line that turns back, crosses itself or covers a stretch twice."""
    x = along(xy)
    heading = np.unwrap(np.arctan2(*np.diff(xy, axis=0).T[::-1]))
    turn = np.degrees(np.abs(np.diff(heading)))
    if np.any(turn > MOST_TURN):
        k = int(np.argmax(turn > MOST_TURN)) + 1
        raise LineFault(
            f"{_place(x, xy, k)}: turns back by {turn[k - 1]:.0f}°",
            f"a line that follows the path without turns over {MOST_TURN:g}°",
        )
    if not shapely.LineString(xy).is_simple:
        parts = shapely.linestrings(np.stack([xy[:-1], xy[1:]], axis=1))
        one, other = shapely.STRtree(parts).query(parts, predicate="intersects")
        k = int(one[other > one + 1].min(initial=len(parts) - 1))
        raise LineFault(
            f"{_place(x, xy, k)}: crosses itself, or covers a stretch twice",
            "a line that passes each place once",
        )


def _check_voids(x: Floats, xy: Floats, y: Floats) -> None:
    """Refuse one elevation all along behind a step that no ground has, and a hole."""
    step, length = y[2:] - y[:-2], x[2:] - x[:-2]
    sheer = np.flatnonzero(np.abs(step) > np.maximum(LEAST_STEP_M, STEEPEST * length))
    flat = np.flatnonzero((y[1:-1] == y[:-2]) & (y[1:-1] == y[2:]))
    beside = any(np.any((flat >= k - 3) & (flat <= k + 3)) for k in sheer)
    if len(sheer) and (beside or np.any(np.sign(step[sheer]) != np.sign(step[sheer[0]]))):
        k = int(sheer[0])
        raise LineFault(
            f"{_place(x, xy, k)}: a step from {y[k]:.0f} to {y[k + 2]:.0f} m above the sea",
            "elevations: declare the value that stands for none as no-data in the terrain model",
        )


def _densified(xy: Floats, terrain: TerrainModel, system: CRS) -> Floats:
    line = shapely.LineString(xy)
    if not SHORTEST_M < line.length < np.inf:
        raise LineFault(f"a line of {line.length:g} m", "a line that leads down a path")
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
        corners = np.array(terrain.source.bounds)
        raise LineFault(
            f"nowhere on {terrain.file}: its top is at {_shown(there[0])} in the system of the "
            f"terrain model ({terrain.crs.name})",
            f"a line on the terrain model, whose cells cover {_shown(corners[:2])} to "
            f"{_shown(corners[2:])}; the line says that it is in {crs.name}",
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


SHAPEFILE_NAME = 10
NAMING = ("name", "id")
PATH_COLUMNS = frozenset({*PathRow.model_fields, "not_observed", "width_m"})
PLACE_COLUMNS = ("x_m", "y_m", "easting_m", "northing_m")
POINT_COLUMNS = ("path_id", *PLACE_COLUMNS, "crs", "land_cover")


def read_drawn(
    files: Sequence[FilePath],
    dem: FilePath,
    land_cover: FilePath | None = None,
    crs: str | None = None,
    releases: Sequence[FilePath] = (),
    only: str | None = None,
) -> list[Drawn]:
    """Read the lines of `files` on the terrain model `dem`, each a path drawn from its top.

    The attribute `path_id` names a path, else `name`, else `id`, in any case; the other
    attributes are those of `paths.csv`. With `land_cover` each point has the attribute
    `land_cover` of the polygon around it, else `open`. `crs` is the system of a terrain model that
    does not name its own; without it that of the lines is taken, and said. A path's release is
    the middle of its part in the polygons of `releases`. `only` names the line of a file of one.
    Raises `AvahazardError` where a file cannot be used; what is wrong with a line is returned.
    """
    layers = [read_layer(file, "line") for file in files]
    given = None if crs is None else read_system(crs)
    if crs is not None and given is None:
        raise AvahazardError(
            f"There is no reference system {crs}.", "Name one such as --crs EPSG:31287."
        )
    systems = {layer.crs for layer in layers}
    assumed = given or (systems.pop() if len(systems) == 1 else None)
    with open_terrain(dem, assumed) as terrain:
        drawn = [_drawn(layer, terrain, land_cover, releases, only) for layer in layers]
        if not terrain.assumed:
            return drawn
        whose = "--crs" if given else "the lines"
        note = f"{dem} names no reference system: that of {whose} was taken, {terrain.crs.name}."
        return [replace(drawn[0], notes=(note, *drawn[0].notes)), *drawn[1:]]


def read_points(file: FilePath) -> FileTable:
    """The points of a file as rows of `events.csv`: attributes and coordinates."""
    layer = read_layer(file, "point")
    code = system_code(layer.crs) if layer.crs.is_projected else None
    names = ("easting_m", "northing_m") if code else ("lon", "lat")
    rows = []
    for number, (point, row) in enumerate(zip(layer.geometry, layer.attributes, strict=True), 1):
        place: dict[str, str] = {}
        if point is not None and point.geom_type == "Point" and not point.is_empty:
            xy = shapely.get_coordinates(point)
            x, y = (xy if code else moved(xy, layer.crs, WGS84))[0]
            place = {names[0]: repr(float(x)), names[1]: repr(float(y))}
            place |= {"crs": code} if code else {}
        rows.append((number, row | place))
    own = tuple(c for c in layer.columns if c not in (*names, "crs"))
    return table_of(layer.file, (*own, *names, *(["crs"] if code else [])), rows)


def avaframe_files(folder: FilePath) -> tuple[FilePath, FilePath, list[FilePath]]:
    """The path, the terrain model and the releases of a folder; refused unless one of each."""
    inputs = folder / "Inputs"
    models = sorted(f for f in inputs.iterdir() if f.suffix.lower() in (".asc", ".tif", ".tiff"))
    lines = sorted((inputs / "LINES").glob("*.shp"))
    path = [f for f in lines if f.stem.lower() == "path_aimec"]
    path = path or [f for f in lines if "AB" in f.stem]
    for found, what in ((models, "terrain model in Inputs"), (path, "path in Inputs/LINES")):
        if len(found) != 1:
            names = ", ".join(f.name for f in found) or "none"
            raise AvahazardError(
                f"{folder} needs one {what}, and has {names}.",
                "A terrain model is .asc or .tif; a path is path_aimec.shp, or has AB in its name.",
            )
    return path[0], models[0], sorted((inputs / "REL").glob("*.shp"))


def _release_elevation(profile: Profile, releases: Sequence[FilePath]) -> float | None:
    """Elevation (m) in the middle of the part of a path that lies in a release area."""
    crs = CRS.from_user_input(profile.crs)
    layers = [read_layer(file, "polygon") for file in releases]
    areas = [moved_geometry(area, of.crs, crs) for of in layers for area in of.geometry if area]
    whole = shapely.union_all([shapely.make_valid(area) for area in areas])
    points = shapely.points(profile.easting_m, profile.northing_m)
    within = np.flatnonzero(shapely.contains_properly(whole, points))
    if not len(within):
        return None
    middle = 0.5 * (profile.x_m[within[0]] + profile.x_m[within[-1]])
    return float(np.interp(middle, profile.x_m, profile.y_m))


def _drawn(
    layer: VectorLayer,
    terrain: TerrainModel,
    land_cover: FilePath | None,
    releases: Sequence[FilePath],
    only: str | None,
) -> Drawn:
    if only is not None and len(layer.geometry) == 1:
        layer = replace(layer, columns=("path_id",), attributes=({"path_id": only},))
    columns, attributes = _path_columns(layer)
    if releases and "release_elevation_m" not in columns:
        columns = (*columns, "release_elevation_m")
    rows: list[tuple[int, dict[str, str]]] = []
    points: list[tuple[int, dict[str, str]]] = []
    crops: list[TerrainCrop] = []
    problems: list[RowProblem] = []
    notes: list[str] = []
    seen: dict[str, int] = {}
    for number, (geometry, row) in enumerate(zip(layer.geometry, attributes, strict=True), 1):
        path_id = row.get("path_id")
        if path_id is None:
            rows.append((number, row))  # the form of paths.csv says what is missing
            continue
        if path_id in seen:
            accepted = f"each one once: it is also in line {seen[path_id]}"
            problems.append(RowProblem(layer.file, number, "path_id", path_id, accepted))
            continue
        seen[path_id] = number
        try:
            profile, crop = line_profile(path_id, geometry, layer.crs, terrain, land_cover)
        except LineFault as fault:
            problems.append(RowProblem(layer.file, number, "geometry", *fault.args))
            rows.append((number, row))
            continue
        release = _release_elevation(profile, releases)
        if release is not None:
            row = {"release_elevation_m": f"{release:.1f}", **row}  # noqa: PLW2901
        if len(row) > 1:
            # Else it says nothing of its path, which may have its row in a paths.csv.
            rows.append((number, row))
        points += [(number, point) for point in _point_rows(profile)]
        crops.append(crop)
        if profile.crs != system_code(terrain.crs):
            notes.append(
                f"{path_id}: its profile is in {profile.crs}: lengths in {terrain.crs.name} are "
                "not those on the ground."
            )
    paths = table_of(layer.file, columns, rows)
    profiles = table_of(layer.file, POINT_COLUMNS, points)
    return Drawn(layer.file, paths, profiles, tuple(crops), tuple(problems), tuple(notes))


def _path_columns(layer: VectorLayer) -> tuple[tuple[str, ...], list[dict[str, str]]]:
    """The attributes under the names of `paths.csv`, with a `path_id`."""
    names = {c: meant if (meant := known_name(c)) in PATH_COLUMNS else c for c in layer.columns}
    if len(set(names.values())) < len(names):
        names = {column: column for column in layer.columns}
    if layer.file.lower().endswith(".shp"):
        # The format cuts names after ten letters.
        names |= {
            c[:SHAPEFILE_NAME]: c for c in PathRow.model_fields if c[:SHAPEFILE_NAME] in names
        }
    rows = [{names[c]: text for c, text in row.items()} for row in layer.attributes]
    known = tuple(names.values())
    if "path_id" in known:
        return known, rows
    naming = next((c for c in ("name", *known) if c in known and c.lower() in NAMING), None)
    if naming is None:
        raise AvahazardError(
            f"The lines of {layer.file} have no attribute path_id, name or id.",
            f"They have: {', '.join(layer.columns) or 'none'}. Add path_id, a name of its own for "
            "each path.",
        )
    # Its number only names the path: no column of one's own.
    places = {"path_id": naming} | {c: c for c in known if c != naming or c == "name"}
    return tuple(places), [{c: row[of] for c, of in places.items() if of in row} for row in rows]


def _point_rows(profile: Profile) -> list[dict[str, str]]:
    """Rows of `profiles.csv`, in millimetres: what is below is the noise of the computation."""
    cover = profile.land_cover or ("",) * len(profile.x_m)
    columns = (getattr(profile, name) for name in PLACE_COLUMNS)
    places = [[f"{value:.3f}" for value in place] for place in zip(*columns, strict=True)]
    about = {"path_id": profile.path_id, "crs": str(profile.crs)}
    return [
        about
        | dict(zip(PLACE_COLUMNS, place, strict=True))
        | ({"land_cover": word} if word else {})
        for place, word in zip(places, cover, strict=True)
    ]
