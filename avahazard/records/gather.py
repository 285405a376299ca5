"""The records of each kind out of the tables of that kind."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence

from avahazard.records.build import build_event, build_path, build_profile, build_speed
from avahazard.records.collection import Records
from avahazard.records.complete import (
    complete_event,
    complete_path,
    complete_profile,
    complete_speed,
)
from avahazard.records.covariates import column_kinds, read_covariates
from avahazard.records.event import Event, Speed
from avahazard.records.forms.event import EventRow
from avahazard.records.forms.path import PathRow
from avahazard.records.forms.profile import ProfileRow
from avahazard.records.forms.row import Row, check_rows
from avahazard.records.forms.straight import StraightRow
from avahazard.records.forms.velocity import VelocityRow
from avahazard.records.intake import Intake, speed_key
from avahazard.records.path import Path, Profile
from avahazard.records.table import Table

PLACES = frozenset({"runout_x_m", "runout_elevation_m", "left_profile"})


def gather_paths(tables: Sequence[Table], known: Records, intake: Intake) -> list[Path]:
    """Return the paths that have a row of their own."""
    stored = column_kinds(path.covariates for path in known.paths)
    columns = set(PathRow.model_fields)
    covariates = read_covariates(tables, columns, stored, intake.problems, intake.notes)
    old = {path.path_id: path for path in known.paths}
    paths = []
    for table in tables:
        rows = _each_once("path", "path_id", table, intake)
        for line, row in check_rows(PathRow, table.file, rows, intake.problems):
            path = build_path(row, covariates[table.file, line])
            paths.append(complete_path(path, old.get(path.path_id), table.header))
    return paths


def gather_profiles(tables: Sequence[Table], known: Records, intake: Intake) -> list[Profile]:
    """Return the profiles of which every point and the order of the points are right."""
    old = {profile.path_id: profile for profile in known.profiles}
    profiles = []
    for table in tables:
        _note_unused(table, ProfileRow, intake)
        # Path by path: checked rows take many times the memory of their cells.
        points: dict[str, array[int]] = {}
        ids = (path_id for block in table.blocks("path_id") for path_id in block)
        for k, path_id in enumerate(ids):
            points.setdefault(path_id, array("q")).append(k)
        for path_id, mine in points.items():
            rows = list(check_rows(ProfileRow, table.file, table.at(mine), intake.problems))
            if not path_id or not rows:
                continue
            if not intake.claim(("profile", path_id), (table.file, rows[0][0]), "path_id", path_id):
                continue
            whole = len(rows) == len(mine)
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
    tables: Sequence[Table], known: Records, intake: Intake, need_runout: bool
) -> list[Event]:
    """Return the events, on a path where the row names one, else on their straight line.

    What the file has no column for is that of the stored event of the same id; but where no runout
    is needed the events are new ones, whatever they are called.
    """
    stored = column_kinds(event.covariates for event in known.events)
    columns = EventRow.model_fields.keys() | StraightRow.model_fields.keys()
    covariates = read_covariates(tables, columns, stored, intake.problems, intake.notes)
    old = {event.event_id: event for event in known.events} if need_runout else {}
    events = []
    for table in tables:
        given = need_runout and bool(PLACES & set(table.header))
        reach = bool({"fall_height_m", "runout_length_m", "h_over_l"} & set(table.header))
        on_path: list[tuple[int, dict[str, str]]] = []
        straight: list[tuple[int, dict[str, str]]] = []
        for line, cells in _each_once("event", "event_id", table, intake):
            (on_path if "path_id" in cells or not reach else straight).append((line, cells))
        found: list[tuple[int, EventRow | StraightRow]] = [
            *check_rows(
                EventRow,
                table.file,
                iter(on_path),
                intake.problems,
                context={"need_runout": given},
            ),
            *check_rows(
                StraightRow,
                table.file,
                iter(straight),
                intake.problems,
                context={"need_runout": need_runout},
            ),
        ]
        for line, row in sorted(found, key=lambda item: item[0]):
            event = build_event(row, covariates[table.file, line])
            events.append(complete_event(event, old.get(event.event_id), table.header))
    return events


def gather_speeds(tables: Sequence[Table], known: Records, intake: Intake) -> list[Speed]:
    """Return the speeds."""
    old = {speed_key(speed): speed for speed in known.speeds}
    speeds = []
    for table in tables:
        _note_unused(table, VelocityRow, intake)
        for line, row in check_rows(VelocityRow, table.file, table.numbered(), intake.problems):
            speed = build_speed(row)
            column, place = (
                ("x_m", speed.x_m) if speed.x_m is not None else ("elevation_m", speed.elevation_m)
            )
            if intake.claim(speed_key(speed), (table.file, line), column, f"{place:g}"):
                speeds.append(complete_speed(speed, old.get(speed_key(speed)), table.header))
    return speeds


def _each_once(
    kind: str, column: str, table: Table, intake: Intake
) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield the rows of `table`, without those whose id another row has taken."""
    for line, cells in table.numbered():
        name = cells.get(column)
        if name is None or intake.claim((kind, name), (table.file, line), column, name):
            yield line, cells


def _note_unused(table: Table, form: type[Row], intake: Intake) -> None:
    unused = [name for name in table.header if name not in form.model_fields]
    if unused:
        intake.notes.append(f"{table.file}: not used are the columns {', '.join(unused)}.")
