"""Files of records found, read, checked row by row, and made into records."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace
from pathlib import Path as FilePath

from avahazard.records.collection import Records
from avahazard.records.conventions import UNKNOWN, Conventions
from avahazard.records.crosscheck import check_one_scale, check_places, check_references
from avahazard.records.errors import AvahazardError, RejectedRows, RowProblem, told_once
from avahazard.records.forms import Kind, read_forms
from avahazard.records.gather import gather_events, gather_paths, gather_profiles, gather_speeds
from avahazard.records.intake import Drawn, Intake
from avahazard.records.path import Path, Profile
from avahazard.records.table import Table, read_tables

TABLES = (".csv", ".tsv", ".xlsx", ".xlsm")
OTHERS = (".xls", ".xlsb", ".ods", ".numbers")


def find_files(sources: Sequence[str | FilePath]) -> list[FilePath]:
    """Return the files of tables that `sources` name, each once, in the order given.

    A folder stands for its `.csv`, `.tsv` and `.xlsx` files (not those of its subfolders), by name.

    Raises:
        AvahazardError: a source does not exist, a folder holds no such file, holds two of one
            name, or a spreadsheet of another kind.
    """
    found: dict[FilePath, FilePath] = {}
    for source in map(FilePath, sources):
        if source.is_dir():
            files = _in_folder(source)
        elif source.exists():
            files = [source]
        else:
            raise AvahazardError(
                f"There is no file or folder {source}.",
                "Name files (.csv, .xlsx), or folders of them.",
            )
        for file in files:
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
    sources: Sequence[str | FilePath],
    known: Records | None = None,
    *,
    need_runout: bool = True,
    given: Conventions = UNKNOWN,
) -> Records:
    """Return the records in `sources`, files or folders of them (docs/data_forms.md).

    Rows may refer to the paths and events of `known`, the records stored before. With
    `need_runout` false an event may lack its runout. `given` says what files may leave open.

    Raises:
        AvahazardError: a source is missing.
        RejectedRows: rows that cannot be taken, all of them.
    """
    intake = read_files(sources, known or Records(), need_runout=need_runout, given=given)
    if intake.problems:
        raise RejectedRows(intake.problems)
    return intake.records


def read_files(
    sources: Sequence[str | FilePath],
    known: Records,
    *,
    need_runout: bool = True,
    drawn: Sequence[Drawn] = (),
    given: Conventions = UNKNOWN,
    profiles_of: Callable[[AbstractSet[str]], Sequence[Profile]] | None = None,
) -> Intake:
    """Read `sources` as `read_records` does, but collect the problems instead of raising.

    Paths that were `drawn` on a map are read with the files. With `profiles_of`, `known` has no
    profiles: those of the paths that the files touch are asked for.
    """
    intake = Intake()
    tables: dict[Kind, list[Table]] = {"paths": [], "profiles": [], "events": [], "velocities": []}
    for file in find_files(sources):
        intake.files.append(str(file))
        faults: list[RowProblem] = []
        sheets = read_tables(file, faults)
        for kind, table in read_forms(sheets, known, intake, faults, need_runout, given):
            tables[kind].append(table)
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
        known = replace(known, profiles=tuple(profiles_of(touched)))
    intake.known = known
    paths = gather_paths(tables["paths"], known, intake)
    profiles = gather_profiles(tables["profiles"], known, intake)
    events = gather_events(tables["events"], known, intake, need_runout)
    speeds = gather_speeds(tables["velocities"], known, intake)

    # A row that was refused still counts as there: what refers to it is not wrong too.
    listed = _ids("path_id", tables["paths"]) | {path.path_id for path in known.paths}
    path_ids = listed | _ids("path_id", tables["profiles"])
    event_ids |= {event.event_id for event in known.events}
    implied = [Path(p.path_id) for p in profiles if p.path_id not in listed]
    intake.records = Records((*paths, *implied), tuple(profiles), tuple(events), tuple(speeds))
    check_references(intake, path_ids, event_ids)
    check_places(intake, known)
    check_one_scale(intake, known)
    intake.problems = told_once(intake.problems)
    return intake


def _ids(column: str, tables: Iterable[Table]) -> set[str]:
    return {text for table in tables for block in table.blocks(column) for text in block if text}
