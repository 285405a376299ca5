"""Files of records found, read, checked row by row, and made into records."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import fields, replace
from itertools import chain, pairwise
from pathlib import Path as FilePath
from sys import intern
from typing import Any, NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.notes import ENGLISH
from avahazard.records.cells import with_remedy
from avahazard.records.collection import (
    DEGREES,
    NUMBERS_OF_POINTS,
    Covariate,
    Event,
    Path,
    Profile,
    Records,
    Speed,
    runout_sigma_m,
    speed_sigma_m_s,
)
from avahazard.records.conventions import UNKNOWN, Conventions, read_directions
from avahazard.records.crosscheck import check_one_scale, check_places, check_references
from avahazard.records.errors import AvahazardError, Problems, RejectedRows, RowProblem, told_once
from avahazard.records.forms import FORMS, PLACES, Kind, column_kinds, read_covariates, read_forms
from avahazard.records.intake import Drawn, Intake, speed_key
from avahazard.records.mapping import Mappings
from avahazard.records.rows import (
    EventRow,
    PathRow,
    ProfileRow,
    Row,
    StraightRow,
    VelocityRow,
    check_rows,
)
from avahazard.records.sheet import WORKBOOKS
from avahazard.records.table import Cells, FileTable

TABLES = (".csv", ".tsv", *WORKBOOKS)
OTHERS = (".numbers",)


def find_files(sources: Sequence[str | FilePath]) -> list[FilePath]:
    """Return the files of tables that `sources` name, each once, in the order given.

    A folder stands for its `.csv`, `.tsv` and `.xlsx` files (not those of its subfolders), by name.
    Raises `AvahazardError` where a source does not exist, a folder holds no such file, holds two of
    one name, or a spreadsheet of another kind.
    """
    found: dict[FilePath, FilePath] = {}
    for source in map(FilePath, sources):
        if not source.exists():
            raise AvahazardError(
                f"There is no file or folder {source}.",
                "Name files (.csv, .xlsx), or folders of them.",
            )
        for file in _in_folder(source) if source.is_dir() else [source]:
            found.setdefault(file.resolve(), file)
    return list(found.values())


def _in_folder(folder: FilePath) -> list[FilePath]:
    # Names that begin so are locks of an open spreadsheet, or hidden.
    listed = sorted(f for f in folder.iterdir() if not f.name.startswith(("~$", ".")))
    files = [f for f in listed if f.suffix.lower() in TABLES]
    stems: dict[str, FilePath] = {}
    for file in files:
        other = stems.setdefault(file.stem.lower(), file)
        if other is not file:
            raise AvahazardError(
                f"{folder} holds {other.name} and {file.name}: which one counts?",
                f"Name the file, such as: avahazard import {other}; or take the other away.",
            )
    for file in listed:
        if file.suffix.lower() in OTHERS:
            raise AvahazardError(
                f"{file} is a spreadsheet of a kind that is not read.",
                "Save it as .xlsx or CSV, or take it out of the folder.",
            )
    if not files:
        raise AvahazardError(
            f"The folder {folder} holds no table (.csv, .xlsx).",
            "Name a folder with paths, profiles, events or velocities as .csv or .xlsx.",
        )
    return files


def read_records(
    sources: Sequence[str | FilePath], known: Records | None = None, *, need_runout: bool = True
) -> Records:
    """Return the records in `sources`, files or folders of them (docs/data_forms.md).

    Rows may refer to `known` records, stored before. With `need_runout` false an event may lack its
    runout. Raises `AvahazardError` where a source is missing; `RejectedRows`, with all of them, for
    rows that cannot be taken.
    """
    intake = read_files(sources, known or Records(), need_runout=need_runout)
    if intake.problems:
        raise RejectedRows(intake.problems)
    return intake.records


def read_files(
    sources: Sequence[str | FilePath],
    known: Records,
    *,
    need_runout: bool = True,
    drawn: Sequence[Drawn] = (),
    points: Sequence[FileTable] = (),
    given: Conventions = UNKNOWN,
    columns: FilePath | None = None,
    convert: Convert | None = None,
    profiles_of: Callable[[Set[str]], Sequence[Profile]] | None = None,
) -> Intake:
    """Read `sources` as `read_records` does, but collect the problems instead of raising.

    Paths that were `drawn` on a map, and `points` as tables, are read with the files. With
    `profiles_of`, `known` has no profiles: those of the paths that the files touch are asked for.
    `columns` is a `columns.toml` for all files, else the one beside each is taken, if any.
    `convert` moves stops that are points into the system of their path.
    """
    intake = Intake(known=known)
    mappings = Mappings(columns, given.unknown)
    tables: dict[Kind, list[FileTable]] = {kind: [] for kind in FORMS}
    for file in find_files(sources):
        intake.files.append(str(file))
        faults: Problems = []
        sheets = mappings.tables(file, faults, intake.notes)
        for kind, table in read_forms(sheets, intake, faults, need_runout, given):
            tables[kind].append(table)
    if of_mappings := mappings.unused(intake.notes):  # what it leaves unread is not at fault
        intake.problems = told_once(of_mappings)
        return intake
    for table in points:
        intake.files.append(table.file)
        for kind, spelt in read_forms([table], intake, (), need_runout, given):
            tables[kind].append(spelt)
    for lines in drawn:
        intake.files.append(lines.file)
        intake.problems += lines.problems
        intake.notes += lines.notes
        tables["paths"].append(lines.paths)
        tables["profiles"].append(lines.profiles)

    event_ids = _ids("event_id", tables["events"])
    if profiles_of is not None:
        named = event_ids | _ids("event_id", tables["velocities"])
        touched = {e.path_id for e in known.events if e.event_id in named and e.path_id}
        for of_kind in tables.values():
            touched |= _ids("path_id", of_kind)
        intake.known = known = replace(known, profiles=tuple(profiles_of(touched)))
    paths = gather_paths(tables["paths"], intake)
    profiles = gather_profiles(tables["profiles"], intake)
    of_paths = {p.path_id: p for p in (*known.profiles, *profiles)}
    events = gather_events(tables["events"], intake, need_runout, of_paths, convert)
    speeds = gather_speeds(tables["velocities"], intake)

    # A row that was refused still counts as there: what refers to it is not wrong too.
    listed = _ids("path_id", tables["paths"]) | {path.path_id for path in known.paths}
    path_ids = listed | _ids("path_id", tables["profiles"])
    event_ids |= {event.event_id for event in known.events}
    implied = [Path(p.path_id) for p in profiles if p.path_id not in listed]
    intake.records = Records((*paths, *implied), tuple(profiles), tuple(events), tuple(speeds))
    check_references(intake, path_ids, event_ids)
    check_places(intake)
    check_one_scale(intake)
    intake.problems = [with_remedy(problem) for problem in told_once(intake.problems)]
    return intake


def _ids(column: str, tables: Iterable[FileTable]) -> set[str]:
    return {text for table in tables for block in table.blocks(column) for text in block if text}


MIN_POINTS = 5


def build_event(
    row: EventRow | StraightRow,
    place: Mapping[str, float],
    covariates: Mapping[str, Covariate],
    old: Event | None,
    header: Collection[str],
) -> Event:
    """Make an event of its row, its `place` on the line, and of `old` what `header` lacks."""
    # The model's own iteration takes four times as long.
    values = {name: value for name, value in row.__dict__.items() if value is not None}
    for name in COORDINATES:
        values.pop(name, None)
    values |= place
    if isinstance(row, StraightRow):
        height, reach = row.height_and_reach
        values |= {"fall_height_m": height, "runout_length_m": reach}
        values |= {"runout_elevation_m": None, "left_profile": False}
        if height is not None:
            values["h_over_l"] = None
    if "runout_sigma_m" in header:
        values.setdefault("runout_sigma_m", _sigma_of(values))
    kept = _kept(old, covariates, header)
    # A row without a path gives its height and reach whole, in one way or another.
    for name in (*ON_A_LINE, *(ON_A_PATH if isinstance(row, StraightRow) else ())):
        kept.pop(name, None)
    if old is not None and old.runout_sigma_m == runout_sigma_m(old.year):
        kept.pop("runout_sigma_m", None)
    if old is not None and old.volume_m3 == old.deposit_m3:
        kept.pop("volume_m3", None)
    values |= kept
    values.setdefault("runout_sigma_m", _sigma_of(values))
    event = Event(**values)
    return event if event.volume_m3 is not None else replace(event, volume_m3=event.deposit_m3)


def _sigma_of(values: Mapping[str, Any]) -> float:
    date = values.get("date")
    return runout_sigma_m(int(date[:4]) if date else None)


def build_profile(
    file: str, points: Sequence[tuple[int, ProfileRow]], problems: Problems
) -> Profile | None:
    """Make a profile of its rows `(line, row)`; None after adding to `problems` what is wrong."""
    (line, first), (end, last) = points[0], points[-1]
    faults: list[tuple[int, str, str, str]] = []
    if len(points) < MIN_POINTS:
        faults.append((line, "path_id", first.path_id, f"at least {MIN_POINTS} points a path"))
    accepted = "more than the x_m of the point before it"
    for (_, left), (line, right) in pairwise(points):
        if right.x_m <= left.x_m:
            faults.append((line, "x_m", f"{right.x_m:g}", accepted))
    if not faults and last.y_m >= first.y_m:
        accepted = f"less than {first.y_m:g}, because x_m runs from the top of the path"
        faults.append((end, "y_m", f"{last.y_m:g}", accepted))
    for name in ("land_cover", "easting_m", "lon", "elevation_sigma_m"):
        empty = [line for line, row in points if getattr(row, name) is None]
        if len(empty) < len(points):
            accepted = f"a {name} at every point of the path, or at none"
            faults += [(line, name, "", accepted) for line in empty]
    accepted = f"{first.crs or 'empty'}, as at the first point of the path"
    faults += [(line, "crs", p.crs or "", accepted) for line, p in points if p.crs != first.crs]
    problems += [RowProblem(file, *fault) for fault in faults]
    if faults:
        return None
    cover = tuple(intern(row.land_cover) for _, row in points if row.land_cover is not None)
    numbers: dict[str, Any] = {}
    for name in NUMBERS_OF_POINTS:
        values = [getattr(row, name) for _, row in points]
        numbers[name] = None if None in values else np.array(values, dtype=np.float64)
    return Profile(first.path_id, **numbers, land_cover=cover or None, crs=first.crs)


ON_A_PATH = ("path_id", "runout_elevation_m", "runout_x_m", "left_profile")
ON_A_LINE = ("fall_height_m", "runout_length_m", "h_over_l")
COORDINATES = ("easting_m", "northing_m", "crs", "lon", "lat")


def complete_profile(
    new: Profile, old: Profile | None, header: Collection[str]
) -> tuple[Profile, list[str]]:
    """`new` with what `header` lacks of `old` where x is the same, and the columns lost."""
    if old is None:
        return new, []
    coordinates = COORDINATES if set(COORDINATES).isdisjoint(header) else ()
    kept: dict[str, Any] = {
        name: getattr(old, name)
        for name in ("land_cover", "elevation_sigma_m", *coordinates)
        if name not in header and getattr(old, name) is not None
    }
    if np.array_equal(new.x_m, old.x_m):
        return replace(new, **kept), []
    return new, list(kept)


def _kept(
    old: Path | Event | None, covariates: Mapping[str, Covariate], header: Collection[str]
) -> dict[str, Any]:
    """The values of `old` in the columns that `header` lacks, with `covariates`."""
    if old is None:
        return {"covariates": covariates}
    kept = {f.name: getattr(old, f.name) for f in fields(old) if f.name not in header}
    further = {c: v for c, v in old.covariates.items() if c not in header}
    return kept | {"covariates": {**further, **covariates}}


ON_PROFILE = frozenset({"runout_x_m", "runout_elevation_m"})


def gather_paths(tables: Sequence[FileTable], intake: Intake) -> list[Path]:
    """Return the paths that have a row of their own."""
    stored, columns = column_kinds(intake.known.paths), PathRow.model_fields.keys()
    covariates = read_covariates(tables, columns, stored, intake.problems, intake.notes)
    old = {path.path_id: path for path in intake.known.paths}
    paths = []
    for table in tables:
        winds = _directions(table, intake)
        rows = _each_once("path", "path_id", table, intake)
        for line, row in check_rows(PathRow, table.file, rows, intake.problems):
            kept = _kept(old.get(row.path_id), covariates[table.file, line], table.header)
            orientation = winds.get(row.orientation or "", row.orientation)
            paths.append(Path(**{**row.model_dump(), "orientation": orientation, **kept}))
    return paths


def _directions(table: FileTable, intake: Intake) -> dict[str, str]:
    """The orientations in English; which of them are none is a note."""
    found = table.counts("orientation")
    winds = read_directions(found)
    if changed := [f"{text} is {wind}" for text, wind in winds.items() if text.upper() != wind]:
        intake.read.append(f"{table.file}: orientation, {', '.join(changed)}")
    if none := [text for text in found if text not in winds]:
        why = ": O is east or west by language" if "O" in none else ""
        intake.notes.append(
            f"{table.file}: orientation {ENGLISH.few(none)} is read as no direction{why}. Write N, "
            "NNE, NE, E (east) to W (west), or give the words classes in columns.toml, such as "
            f'{{from = "{table.columns["orientation"].spelt}", classes = {{"{none[0]}" = "…"}}}}.'
        )
    return {text: wind for text, wind in winds.items() if text.upper() != wind}


def gather_profiles(tables: Sequence[FileTable], intake: Intake) -> list[Profile]:
    """Return the profiles of which every point and the order of the points are right."""
    old = {profile.path_id: profile for profile in intake.known.profiles}
    profiles = []
    for table in tables:
        _note_unused(table, ProfileRow, intake)
        # Path by path: checked rows take many times the memory of their cells.
        points: dict[str, array[int]] = {}
        for k, path_id in enumerate(chain.from_iterable(table.blocks("path_id"))):
            points.setdefault(path_id, array("q")).append(k)
        for path_id, selected in points.items():
            rows = list(check_rows(ProfileRow, table.file, table.at(selected), intake.problems))
            if not path_id or not rows:
                continue
            if not intake.claim(("profile", path_id), (table.file, rows[0][0]), "path_id", path_id):
                continue
            whole = len(rows) == len(selected)
            profile = build_profile(table.file, rows, intake.problems) if whole else None
            if profile is None:
                continue
            profile, lost = complete_profile(profile, old.get(path_id), table.header)
            if lost:
                what = ", ".join(lost)
                note = f"{table.file}: {path_id} has other points than before, and no {what}."
                intake.notes.append(note)
            profiles.append(profile)
    return profiles


def gather_events(
    tables: Sequence[FileTable],
    intake: Intake,
    need_runout: bool,
    profiles: Mapping[str, Profile],
    convert: Convert | None,
) -> list[Event]:
    """Return the events, on a path where the row names one, else on their straight line.

    What the file has no column for is that of the stored event of the same id; but where no runout
    is needed the events are new ones, whatever they are called.
    """
    stored = column_kinds(intake.known.events)
    columns = EventRow.model_fields.keys() | StraightRow.model_fields.keys()
    covariates = read_covariates(tables, columns, stored, intake.problems, intake.notes)
    old = {event.event_id: event for event in intake.known.events} if need_runout else {}
    events = []
    for table in tables:
        header, placed = table.header, dict[str, float]()
        if not ON_PROFILE & set(header) and {"easting_m", "lon"} & set(header):
            header = (*header, *ON_PROFILE)  # the stored place is not kept beside a new point
        for line, row in _event_rows(table, intake, need_runout):
            place: dict[str, float] = {}
            if isinstance(row, EventRow) and row.point:
                stop = place_stop(row, profiles.get(row.path_id), convert)
                if isinstance(stop, PlacedStop):
                    placed[row.event_id] = stop.distance_m
                    place["runout_x_m"] = round(stop.x_m, 3)
                else:
                    column, accepted = stop
                    intake.refuse(("event", row.event_id), column, getattr(row, column), accepted)
            before = old.get(row.event_id)
            events.append(build_event(row, place, covariates[table.file, line], before, header))
        if placed:
            far = max(placed, key=placed.__getitem__)
            intake.notes.append(
                f"{table.file}: {len(placed)} stops are points, put on the lines of their paths, "
                f"at most {placed[far]:.0f} m from them ({far})."
            )
    return events


def _event_rows(
    table: FileTable, intake: Intake, need_runout: bool
) -> Iterator[tuple[int, EventRow | StraightRow]]:
    """Yield the rows of events: of those on a path, the file may hold the runouts or not."""
    placed = need_runout and not set(PLACES).isdisjoint(table.header)
    straight = not set(ON_A_LINE).isdisjoint(table.header)
    for line, cells in _each_once("event", "event_id", table, intake):
        form: type[EventRow | StraightRow] = StraightRow
        context = {"need_runout": need_runout}
        if "path_id" in cells or not straight:
            form, context = EventRow, {"need_runout": placed}
        yield from check_rows(form, table.file, [(line, cells)], intake.problems, context)


def gather_speeds(tables: Sequence[FileTable], intake: Intake) -> list[Speed]:
    """Return the speeds."""
    old = {speed_key(speed): speed for speed in intake.known.speeds}
    speeds = []
    for table in tables:
        _note_unused(table, VelocityRow, intake)
        for line, row in check_rows(VelocityRow, table.file, table.numbered(), intake.problems):
            # Where both are given the distance decides, not the elevation.
            column = "elevation_m" if row.x_m is None else "x_m"
            place = {column: getattr(row, column)}
            sigma = row.speed_sigma_m_s or speed_sigma_m_s(row.speed_m_s)
            speed = Speed(row.event_id, row.speed_m_s, sigma, **place)
            key = speed_key(speed)
            before = None if "speed_sigma_m_s" in table.header else old.get(key)
            # An error that was given is kept, one that was assumed is not.
            if before and before.speed_sigma_m_s != speed_sigma_m_s(before.speed_m_s):
                speed = replace(speed, speed_sigma_m_s=before.speed_sigma_m_s)
            if intake.claim(key, (table.file, line), column, f"{place[column]:g}"):
                speeds.append(speed)
    return speeds


def _each_once(kind: str, column: str, table: FileTable, intake: Intake) -> Iterator[Cells]:
    """Yield the rows of `table`, without those whose id another row has taken."""
    for line, cells in table.numbered():
        name = cells.get(column)
        if name is None or intake.claim((kind, name), (table.file, line), column, name):
            yield line, cells


def _note_unused(table: FileTable, form: type[Row], intake: Intake) -> None:
    unused = [name for name in table.header if name not in form.model_fields]
    if unused:
        intake.notes.append(f"{table.file}: not used are the columns {', '.join(unused)}.")


FARTHEST_M = 200.0
"""A stop farther from the line of its path belongs to another path, or is in another system."""
AS_NEAR_M = 10.0
"""Two places on the line whose distances to the stop differ by less cannot be distinguished."""


Convert = Callable[[Floats, str, str], Floats]
"""A point `[2]` moved from one reference system to another; nan where it has no place there."""


class PlacedStop(NamedTuple):
    """Its distance along the path and from the line, in m."""

    x_m: float
    distance_m: float


def place_stop(
    row: EventRow, profile: Profile | None, convert: Convert | None
) -> PlacedStop | tuple[str, str]:
    """The place on the line of `profile` nearest to the coordinates of `row`.

    Without one, the column at fault and what would be accepted. Without `convert`, coordinates in
    another system than those of the line are not accepted.
    """
    column = row.point
    if profile is None:
        return "path_id", "a path with a profile on the map, for a stop that is a point"
    xy, system = profile.on_map or (np.empty((0, 2)), "")
    if not system:
        return column, "runout_x_m: the profile of the path has no coordinates"
    if column == "easting_m" and row.crs is None:
        return column, "a crs beside easting_m and northing_m"
    place, given = (row.lon, row.lat), DEGREES
    if column == "easting_m":
        place, given = (row.easting_m, row.northing_m), str(row.crs)
    point = np.array(place, np.float64)
    if given != system:
        point = np.full(2, np.nan) if convert is None else convert(point, given, system)
    if not np.all(np.isfinite(point)):
        return column, f"coordinates that exist in {system}"
    if system == DEGREES:  # as metres near the stop
        metres = 111_195.0 * np.array([np.cos(np.radians(point[1])), 1.0])
        xy, point = (xy - point) * metres, np.zeros(2)
    step = np.diff(xy, axis=0)
    share = np.einsum("ij,ij->i", point - xy[:-1], step) / np.einsum("ij,ij->i", step, step)
    inside = np.clip(share, 0.0, 1.0)
    distance = np.hypot(*(xy[:-1] + inside[:, None] * step - point).T)
    x = profile.x_m[:-1] + inside * np.diff(profile.x_m)
    k = int(np.argmin(distance))
    accepted = ""
    beyond = (share[k] - 1.0) * float(np.hypot(*step[k])) if k == len(step) - 1 else 0.0
    near = np.flatnonzero(distance <= distance[k] + AS_NEAR_M)
    gaps = np.flatnonzero(np.diff(near) > 1)
    if distance[k] > FARTHEST_M:
        accepted = f"a point within {FARTHEST_M:g} m of the path's line: it is {distance[k]:.0f} m"
    elif beyond > AS_NEAR_M:
        accepted = (
            f"a point on the path: it is {beyond:.0f} m past the end of its line; draw the line "
            "longer, or left_profile 1"
        )
    elif len(gaps):
        one, other = x[near[gaps[0]]], x[near[gaps[0] + 1]]
        accepted = f"runout_x_m: the line passes twice, at {one:.0f} and {other:.0f} m"
    return (column, accepted) if accepted else PlacedStop(float(x[k]), float(distance[k]))
