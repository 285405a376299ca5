"""The database itself: made, brought up to date, looked at, checked, copied."""

from __future__ import annotations

from avahazard.inference.seeds import generator
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Report, Rows, silent
from avahazard.results.database import Checked, Copied, Created, DatabaseState, Recomputed, Upgraded
from avahazard.store import upkeep
from avahazard.store.results import list_models
from avahazard.store.session import database_name, database_url, reading, sqlite_file
from avahazard.store.upkeep import backup, backup_beside, check_database

SAMPLE = 3
"""Models that a full check calibrates again."""


def init_database(database: str) -> Created:
    """Create the tables of `database`; `created` is false where it exists.

    Raises `AvahazardError` where it holds other tables, or cannot be written.
    """
    before = upkeep.create(database)
    created = before == "empty"
    return Created(database_name(database), created, "current" if created else before)


def upgrade_database(database: str) -> Upgraded:
    """Run the migrations that `database` lacks; an SQLite file is copied beside itself before.

    Raises `AvahazardError` where it is missing, empty, of another program, or newer than this one.
    """
    before = upkeep.status(database)
    copy = None
    if before.state == "old" and (file := sqlite_file(database_url(database))) is not None:
        copy = backup_beside(database, f"{file}.before-{before.head}")
    upkeep.upgrade(database)
    after = upkeep.status(database)
    return Upgraded(after.database, before.revision, after.revision, copy)


def database_status(database: str) -> DatabaseState:
    """Return the state of the schema of `database`, its revision and its counts.

    Raises `AvahazardError` where it is missing or cannot be read.
    """
    return upkeep.status(database)


def check(database: str, *, full: bool = False, report: Report = silent) -> Checked:
    """Return whether `database` is whole, and the list of its problems.

    With `full` up to `SAMPLE` of its models, chosen at random, are calibrated again and held
    against what is stored, draw by draw. Raises `AvahazardError` where it is missing, of another
    schema, or cannot be read at all.
    """
    with reading(database) as session:
        problems = check_database(session)
        names = [model.name for model in list_models(session)]
    if not full:
        return Checked(database_name(database), not problems, tuple(problems))
    rng = generator(len(names), "db check")
    chosen = sorted(rng.choice(len(names), min(SAMPLE, len(names)), replace=False))
    again = [_recomputed(database, names[k], report) for k in chosen]
    problems += [
        f"{found.model} calibrated again has other draws than those stored ({found.why_not})."
        for found in again
        if found.identical is False
    ]
    return Checked(database_name(database), not problems, tuple(problems), Rows(again))


def _recomputed(database: str, name: str, report: Report) -> Recomputed:
    from avahazard.workflow.calibrate import rerun  # noqa: PLC0415 (slow)

    try:
        found = rerun(database, name, report=report)
    except AvahazardError as error:
        return Recomputed(name, None, error.message)
    if found.identical:
        return Recomputed(name, True, None)
    reasons = (", ".join(found.differences), *found.notes)
    if found.notes:  # other versions need not give the same bits
        return Recomputed(name, None, "; ".join(reasons))
    return Recomputed(name, False, reasons[0])


def backup_database(database: str, target: str) -> Copied:
    """Copy an SQLite `database` to the new file `target`, also while it is used.

    Raises `AvahazardError` where it is not SQLite or missing, or `target` is there already.
    """
    backup(database, target)
    return Copied(database_name(database), target)
