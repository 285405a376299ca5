"""The database: made, brought up to date, filled from files, looked at, checked, copied."""

from collections.abc import Sequence
from functools import partial
from importlib.resources import files
from pathlib import Path as FilePath

import numpy as np

from avahazard.arrays import Floats
from avahazard.gis import require_packages
from avahazard.inference.seeds import generator
from avahazard.records.crosscheck import dwarfing, repeated, spelled_variously
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.records.intake import Drawn, merge_records
from avahazard.records.mapping import BESIDE
from avahazard.records.reading import find_files, read_files
from avahazard.records.table import FileTable
from avahazard.results import files as results
from avahazard.results.base import Report, Rows, silent
from avahazard.store import upkeep
from avahazard.store.records import load_profiles, load_records, save_records, save_terrain
from avahazard.store.results import list_models
from avahazard.store.session import database_name, database_url, reading, sqlite_file, writing
from avahazard.store.upkeep import backup, check_database
from avahazard.workflow.next_step import after_import
from avahazard.workflow.requests import ImportRequest

SAMPLE = 3
"""Models that a full check calibrates again."""


def init_database(database: str) -> results.Created:
    """Create the tables of `database`; `created` is false where it exists.

    Raises `AvahazardError` where it holds other tables, or cannot be written.
    """
    return results.Created(database_name(database), upkeep.create(database) == "empty")


def upgrade_database(database: str) -> results.Upgraded:
    """Run the migrations that `database` lacks; an SQLite file is copied beside itself before.

    Raises `AvahazardError` where it is missing, empty, of another program, or newer than this one.
    """
    before = upkeep.status(database)
    copy = None
    if before.state == "old" and (file := sqlite_file(database_url(database))) is not None:
        copy = f"{file}.before-{before.head}"
        if not FilePath(copy).exists():
            backup(database, copy)
    upkeep.upgrade(database)
    after = upkeep.status(database)
    return results.Upgraded(after.database, before.revision, after.revision, copy)


database_status = upkeep.status


def check(database: str, *, full: bool = False, report: Report = silent) -> results.Checked:
    """Return whether `database` is whole, and the list of its problems.

    With `full` up to `SAMPLE` of its models, chosen at random, are calibrated again and held
    against what is stored, draw by draw. Raises `AvahazardError` where it cannot be read.
    """
    with reading(database) as session:
        problems = check_database(session)
        names = [model.name for model in list_models(session)]
    again = None
    if full:
        rng = generator(len(names), "db check")
        chosen = sorted(rng.choice(len(names), min(SAMPLE, len(names)), replace=False))
        again = Rows(_recomputed(database, names[k], report) for k in chosen)
        problems += [
            f"{found.model} calibrated again has other draws than those stored ({found.why_not})."
            for found in again
            if found.identical is False
        ]
    return results.Checked(database_name(database), not problems, tuple(problems), again)


def _recomputed(database: str, name: str, report: Report) -> results.Recomputed:
    from avahazard.workflow.calibrate import rerun  # noqa: PLC0415 (slow)

    try:
        found = rerun(database, name, report=report)
    except AvahazardError as error:
        return results.Recomputed(name, None, error.message)
    if found.identical:
        return results.Recomputed(name, True, None)
    reasons = "; ".join((", ".join(found.differences), *found.notes))
    # Other versions need not give the same bits.
    return results.Recomputed(name, None if found.notes else False, reasons)


def backup_database(database: str, target: str) -> results.Copied:
    """Copy an SQLite `database` to the new file `target`, also while it is used.

    Raises `AvahazardError` where it is not SQLite or missing, or `target` is there already.
    """
    backup(database, target)
    return results.Copied(database_name(database), target)


LINES = (".gpkg", ".geojson", ".shp", ".kml", ".kmz", ".gpx")


READ_PLAINLY = ImportRequest()


def import_files(
    database: str, sources: Sequence[str | FilePath], request: ImportRequest = READ_PLAINLY
) -> results.Import:
    """Import `sources` into `database`, all or nothing.

    Tables or folders of them (docs/data_forms.md), files of `LINES`, each line a path drawn from
    its top, or of points, the stops of events; folders as AvaFrame has them (`Inputs/`). Raises
    `AvahazardError` where the database or a source cannot be used, or there are lines without a
    terrain model; `RejectedRows` for rows that cannot be taken, all of them.
    """
    dry_run = request.dry_run
    of_avaframe = [FilePath(s) for s in sources if (FilePath(s) / "Inputs").is_dir()]
    lines = [FilePath(s) for s in sources if FilePath(s).suffix.lower() in LINES]
    tables = [s for s in sources if FilePath(s) not in lines and FilePath(s) not in of_avaframe]
    if lines or of_avaframe:
        require_packages()
    points = _points(lines)
    drawn = [one for folder in of_avaframe for one in _of_avaframe(folder, request)]
    if not drawn or lines or request.dem is not None:
        drawn += _drawn([file for file in lines if file not in points], request)
    with (reading if dry_run else writing)(database) as session:
        intake = read_files(
            tables,
            load_records(session, profiles=False),
            drawn=drawn,
            points=list(points.values()),
            given=request.conventions,
            columns=None if request.columns is None else mapping_file(request.columns),
            convert=_converted,
            profiles_of=partial(load_profiles, session),
        )
        new, counts = merge_records(intake, update=request.update)
        written = {event.event_id for event in new.events}
        kept = (event for event in intake.known.events if event.event_id not in written)
        every = [*kept, *new.events]
        volumes = np.log(np.array([event.volume_m3 or np.nan for event in every]))
        intake.notes += [
            f"the volume of {every[i].event_id}, {every[i].volume_m3:g} m3, dwarfs all others. "
            "Is its unit m3?"
            for i in dwarfing(volumes)
            if every[i].event_id in written
        ]
        intake.notes += [*repeated(every, written), *spelled_variously(every)]
        if intake.problems:
            raise RejectedRows(intake.problems)
        if not dry_run:
            save_records(session, new)
            crops = [crop for one in drawn for crop in one.terrain]
            save_terrain(session, crops, outdated=[p.path_id for p in new.profiles])
    return results.Import(
        dry_run,
        tuple(intake.files),
        tuple(intake.read),
        Rows(intake.understood),
        results.ImportedRecords(**counts),
        tuple(intake.notes),
        None if dry_run else after_import(database),
    )


def guess_columns(sources: Sequence[str | FilePath]) -> results.GuessedColumns:
    """Write a first `columns.toml` beside tables of one folder, or the folder, to be corrected.

    Raises `AvahazardError` where there is one, or a file holds no table that can be guessed;
    `RejectedRows` where one cannot be read.
    """
    from avahazard.records.guess import as_toml, guess_tables  # noqa: PLC0415 (slow to import)

    files = find_files(sources)
    for file in files:
        if file.parent != files[0].parent:
            raise AvahazardError(
                f"{file} is in another folder than {files[0]}.",
                "Put them in one folder: columns.toml stands beside its tables.",
            )
    target = files[0].parent / BESIDE
    if target.exists():
        raise AvahazardError(f"{target} is there already.", "Read it, or take it away first.")
    tables = []
    for file in files:
        found, problems = guess_tables(file)
        if problems:
            raise RejectedRows(problems)
        if not any(table.guesses for table in found):
            raise AvahazardError(
                f"No column of {file} is like one of the forms.",
                "docs/data_forms.md has the columns; write a columns.toml by hand.",
            )
        tables += [(file.name, table) for table in found if table.guesses]
    target.write_text(as_toml(tables), encoding="utf-8")
    return results.GuessedColumns(
        tuple(map(str, files)),
        str(target),
        Rows(guess for _, found in tables for guess in found.guesses),
        tuple(f"{found.table.file}: {text}" for _, found in tables for text in found.open),
    )


def mapping_file(name: str | FilePath) -> FilePath:
    """A `columns.toml`: a file, or one of those that come with the program, by its name."""
    shipped = FilePath(str(files("avahazard.data"))) / "mappings"
    if not FilePath(name).is_file() and (shipped / f"{name}.toml").is_file():
        return shipped / f"{name}.toml"
    return FilePath(name)


def _converted(point: Floats, source: str, target: str) -> Floats:
    require_packages()
    from avahazard.gis.systems import moved, read_system  # noqa: PLC0415 (may be missing)

    one, other = read_system(source), read_system(target)
    if one is None or other is None:
        return np.full(2, np.nan)
    return moved(point[None, :], one, other).ravel()


def _points(files: Sequence[FilePath]) -> dict[FilePath, FileTable]:
    """The files that hold points alone, as tables: stops on the map."""
    if not files:
        return {}
    from avahazard.gis.drawn_lines import read_points  # noqa: PLC0415 (may be missing)
    from avahazard.gis.vector_layer import holds_points  # noqa: PLC0415 (may be missing)

    return {file: read_points(file) for file in files if holds_points(file)}


def _of_avaframe(folder: FilePath, request: ImportRequest) -> list[Drawn]:
    """The path of a folder as AvaFrame has it, on its own terrain model."""
    from avahazard.gis.drawn_lines import avaframe_files, read_drawn  # noqa: PLC0415

    path, dem, releases = avaframe_files(folder)
    name = folder.resolve().name
    return read_drawn([path], dem, request.land_cover, request.crs, releases, name)


def _drawn(lines: Sequence[FilePath], request: ImportRequest) -> list[Drawn]:
    """The lines on their terrain model; none where no file holds lines."""
    dem, land_cover, crs = request.dem, request.land_cover, request.crs
    if not lines:
        if dem is None and land_cover is None and crs is None:
            return []
        raise AvahazardError(
            "A terrain model or land cover is read along lines, and no file of lines is named.",
            f"Name one that ends in {', '.join(LINES)}.",
        )
    if dem is None:
        raise AvahazardError(
            f"{lines[0]} holds lines: their profiles need a terrain model.",
            "Name it: avahazard import LINES --dem DEM.tif",
        )
    from avahazard.gis.drawn_lines import read_drawn  # noqa: PLC0415 (may be missing)

    return read_drawn(lines, dem, land_cover, crs)
