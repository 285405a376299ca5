"""The results of a model as files for a GIS or a spreadsheet."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Concatenate, ParamSpec

import numpy as np

from avahazard.effects.site import release_place, stop_place
from avahazard.gis import require_packages
from avahazard.notes import Note
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Path, Records, no_profiles, of_path
from avahazard.records.errors import AvahazardError
from avahazard.report import hazard_tables
from avahazard.results.base import Rows
from avahazard.results.files import Export, Layer
from avahazard.results.hazard import HazardRow, ZonedPath
from avahazard.store import results as store
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.whole_file import written_whole
from avahazard.workflow.stored import notes_of

if TYPE_CHECKING:
    from avahazard.gis.hazard_map import MapLayer, MappedPath

Holds = ParamSpec("Holds")
ENDINGS = (".gpkg", ".geojson", ".csv", ".xlsx")


def export(database: str, name: str, file: FilePath) -> Export:
    """Write the latest bounds and zones by the model `name` to `file`, for what its name ends in.

    `.gpkg`: layers with their styles, in the paths' own reference systems; `.geojson`: the same on
    WGS 84; `.csv`: the rows of `hazard`; `.xlsx`: these, and zones on a sheet of their own. A file
    that an export made before is replaced, no other one. Raises `AvahazardError` where there is no
    such model, no bounds are stored by it, `file` has another ending or is somebody else's, or no
    path has coordinates.
    """
    ending = ending_of(file)
    with reading(database) as session:
        model = store.load_model(session, name)
        rows = store.latest_by_path(session, store.BOUNDS, name)
        zones = store.latest_by_path(session, store.ZONES, name)
        records = load_records(session)
        known = notes_of(model, records)
    if not rows and not records.profiles:
        raise no_profiles()
    if not rows:
        raise AvahazardError(
            f"No bounds are stored by {name}.",
            f"Draw them first: avahazard hazard {shlex.quote(name)}",
        )
    bounds = []
    for row in rows:  # its notes when it was computed, and what is known of its model today
        noted = (*map(Note.read, row.get("notes", ())), *known)
        bounds.append(HazardRow.from_dict({**row, "notes": tuple(dict.fromkeys(noted))}))
    zoned = [ZonedPath.from_dict(z) for z in zones]
    lacking = [f"no zones are stored by {name}."] if not zones else []
    if ending == ".csv":
        replace_file(file, hazard_tables.is_own_csv, hazard_tables.write_hazard, bounds)
        alone = ["a .csv has no zones: an .xlsx, a .gpkg or a .geojson has them."] if zoned else []
        return Export(name, str(file), Rows([Layer("hazard", len(rows), None)]), (*known, *alone))
    if ending == ".xlsx":
        sheets = {"hazard": hazard_tables.hazard_sheet(bounds)}
        sheets |= {"zones": hazard_tables.zones_sheet(zoned)} if zoned else {}
        replace_file(file, hazard_tables.is_own_workbook, hazard_tables.write_workbook, sheets)
        layers = Rows(Layer(title, len(flat), None) for title, (_, flat) in sheets.items())
        return Export(name, str(file), layers, (*known, *lacking))
    made, notes = map_layers(records, bounds, zoned)
    from avahazard.gis import map_files  # noqa: PLC0415 (may be missing)

    if ending == ".gpkg":
        day = np.datetime64(store.now(), "ms")
        replace_file(file, map_files.is_own_geopackage, map_files.write_geopackage, made, day)
    else:
        replace_file(file, map_files.is_own_geojson, map_files.write_geojson, made)
    layers = Rows(Layer(m.name, len(m.features), m.code) for m in made)
    return Export(name, str(file), layers, (*known, *notes, *lacking))


def ending_of(file: FilePath) -> str:
    """The ending of a file to write. Raises `AvahazardError` where it is none of `ENDINGS`."""
    if (ending := file.suffix.lower()) not in ENDINGS:
        raise AvahazardError(
            f"{file} does not end in {', '.join(ENDINGS)}.",
            "The ending says what is written: GeoPackage, GeoJSON or a table.",
        )
    return ending


def replace_file(
    file: FilePath,
    is_own: Callable[[FilePath], bool],
    write: Callable[Concatenate[FilePath, Holds], None],
    *what: Holds.args,
    **how: Holds.kwargs,
) -> None:
    """Write beside `file` and put it in its place when it is whole.

    Raises `AvahazardError` where there is no such folder, or a file that is not our own.
    """
    if not file.parent.is_dir():
        raise AvahazardError(f"There is no folder {file.parent}.", "Make the folder first.")
    if file.exists() and not (file.is_file() and is_own(file)):
        raise AvahazardError(
            f"{file} is there already, and no export made it; nothing was written.",
            "Name another file, or remove that one first.",
        )
    with written_whole(file) as part:
        write(part, *what, **how)


def map_layers(
    records: Records, rows: Sequence[HazardRow], zones: Sequence[ZonedPath]
) -> tuple[list[MapLayer], list[str]]:
    """The layers, and notes on what has no place on them.

    Raises `AvahazardError` where no path has coordinates.
    """
    require_packages()
    from avahazard.gis.hazard_map import hazard_layers  # noqa: PLC0415

    drawn: list[MappedPath] = []
    lacking: dict[str, list[str]] = {}
    for path in records.paths:
        one = drawn_path(records, path)
        if isinstance(one, str):
            lacking.setdefault(one, []).append(path.path_id)
        else:
            drawn.append(one)
    reasons = [f"{', '.join(paths)}: {reason}" for reason, paths in lacking.items()]
    if not drawn:
        raise AvahazardError(
            f"No path can be drawn on a map ({'; '.join(reasons) or 'there are none'}).",
            "Give profiles.csv easting_m, northing_m and crs, or lon and lat, and import it with "
            "--update; or import the paths as lines with --dem. A .csv needs no coordinates.",
        )
    notes = [f"not on the map are {reason}" for reason in reasons]
    zoned = {zone.path_id for zone in zones}
    bare = [d.path.path_id for d in drawn if d.width_m is None and d.path.path_id in zoned]
    if bare:
        notes.append(f"zones as lines only, for want of a column width_m: {', '.join(bare)}.")
    return hazard_layers(drawn, rows, zones), notes


def drawn_path(records: Records, path: Path) -> MappedPath | str:
    """A path on the map with its recorded stops, or what it lacks for that."""
    from avahazard.gis.hazard_map import MappedPath, path_line  # noqa: PLC0415

    selected = of_path(records, path.path_id)
    if not selected.profiles:
        return "no profile"
    (profile,), events = selected.profiles, selected.events
    if isinstance(line := path_line(profile), str):
        return line
    smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    stops = [(event, x) for event in events if (x := stop_place(smooth, event)) is not None]
    return MappedPath(path, line, release_place(smooth, path.release_elevation_m), tuple(stops))
