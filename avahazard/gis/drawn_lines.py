"""Files of lines, one line a path, made into rows of paths and profiles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath

from avahazard.gis.line_profile import LineFault, LineProfile, line_profile
from avahazard.gis.systems import read_system
from avahazard.gis.terrain_model import TerrainModel, open_terrain
from avahazard.gis.vector_layer import VectorLayer, read_layer
from avahazard.records.drawn import Drawn
from avahazard.records.errors import AvahazardError, RowProblem
from avahazard.records.files.names import known_name
from avahazard.records.forms.path import PathRow
from avahazard.records.table import table_of
from avahazard.records.terrain_crop import TerrainCrop

SHAPEFILE_NAME = 10
NAMING = ("name", "id")
PATH_COLUMNS = frozenset({*PathRow.model_fields, "not_observed", "release_area_m2", "width_m"})
POINT_COLUMNS = ("path_id", "x_m", "y_m", "easting_m", "northing_m", "crs", "land_cover")


def read_drawn(
    files: Sequence[FilePath],
    dem: FilePath,
    land_cover: FilePath | None = None,
    crs: str | None = None,
) -> list[Drawn]:
    """Read the lines of `files` on the terrain model `dem`, each a path drawn from its top.

    The attribute `path_id` names a path, else `name`, else `id`, in any case; the other
    attributes are those of `paths.csv`. With `land_cover` each point has the attribute
    `land_cover` of the polygon around it, else `open`. `crs` is the system of a terrain model that
    does not name its own; without it that of the lines is taken, and said.

    Raises:
        AvahazardError: a file cannot be used. What is wrong with single lines is returned.
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
        drawn = [_drawn(layer, terrain, land_cover) for layer in layers]
        if not terrain.assumed:
            return drawn
        whose = "--crs" if given else "the lines"
        note = f"{dem} names no reference system: that of {whose} was taken, {terrain.crs.name}."
        return [replace(drawn[0], notes=(note, *drawn[0].notes)), *drawn[1:]]


def _drawn(layer: VectorLayer, terrain: TerrainModel, land_cover: FilePath | None) -> Drawn:
    columns, attributes = _path_columns(layer)
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
            profile = line_profile(path_id, geometry, layer.crs, terrain, land_cover)
        except LineFault as fault:
            problems.append(RowProblem(layer.file, number, "geometry", fault.value, fault.accepted))
            rows.append((number, row))
            continue
        if len(row) > 1:
            # Else it says nothing of its path, which may have its row in a paths.csv.
            rows.append((number, row))
        points += [(number, point) for point in _point_rows(path_id, profile)]
        crops.append(profile.terrain)
        notes += _notes(path_id, profile, terrain)
    return Drawn(
        layer.file,
        table_of(layer.file, columns, rows),
        table_of(layer.file, POINT_COLUMNS, points),
        tuple(crops),
        tuple(problems),
        tuple(notes),
    )


def _path_columns(layer: VectorLayer) -> tuple[tuple[str, ...], list[dict[str, str]]]:
    """The attributes under the names of `paths.csv`, with a `path_id`."""
    names = {column: _meant(column) for column in layer.columns}
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
    named = [{"path_id": row[naming], **row} if naming in row else row for row in rows]
    if naming == "name":
        return ("path_id", *known), named
    # Its number only names the path: no column of one's own.
    others = tuple(c for c in known if c != naming)
    return ("path_id", *others), [{c: v for c, v in r.items() if c != naming} for r in named]


def _meant(column: str) -> str:
    """The column of `paths.csv` that an attribute spells in another way, else itself."""
    known = known_name(column)
    return known if known in PATH_COLUMNS else column


def _point_rows(path_id: str, profile: LineProfile) -> list[dict[str, str]]:
    """Rows of `profiles.csv`, in millimetres: what is below is the noise of the computation."""
    cover = profile.cover or ("",) * len(profile.x)
    columns = zip(profile.x, profile.y, profile.easting, profile.northing, cover, strict=True)
    rows = []
    for x, y, easting, northing, word in columns:
        cells = {
            "path_id": path_id,
            "x_m": f"{x:.3f}",
            "y_m": f"{y:.3f}",
            "easting_m": f"{easting:.3f}",
            "northing_m": f"{northing:.3f}",
            "crs": profile.crs,
        }
        rows.append(cells | ({"land_cover": word} if word else {}))
    return rows


def _notes(path_id: str, profile: LineProfile, terrain: TerrainModel) -> list[str]:
    if profile.crs == terrain.code:
        return []
    return [
        f"{path_id}: its profile is in {profile.crs}: lengths in {terrain.crs.name} are not "
        "those on the ground."
    ]
