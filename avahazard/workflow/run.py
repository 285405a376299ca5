"""A whole project, from its records to its bounds and pages; only what is out of date is done.

Nothing is kept besides the database: a step is up to date where what it would store is there
already, made of the same records. So a run that was interrupted goes on where it was.
"""

from __future__ import annotations

from pathlib import Path as FilePath

from avahazard.records.conventions import Conventions
from avahazard.results.base import Report, Rows, silent
from avahazard.results.project import ProjectRun, Step
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.database import init_database
from avahazard.workflow.import_files import import_files
from avahazard.workflow.project.answers import project_answers
from avahazard.workflow.project.file import read_project
from avahazard.workflow.project.models import project_models
from avahazard.workflow.project.state import DONE, UP_TO_DATE, ProjectState
from avahazard.workflow.stored.notes import notes_of


def run_project(
    file: FilePath,
    database: str,
    report: Report = silent,
) -> ProjectRun:
    """Run the project of `file`, in its own database or else in `database`.

    Import, calibrate, compare, diagnose (and add what is named, if the file says so), hazard,
    zones, report, export. A stored model is never overwritten: where the records or the file have
    changed since, the next one is called NAME-2.

    Raises:
        AvahazardError: the file is not that of a project, or a step could not be done; those
            before it stay done.
    """
    project = read_project(file)
    folder = file.absolute().parent
    if project.database is not None:
        named = project.database
        database = named if "://" in named else str(folder / named)
    run = ProjectState(project, folder, database, report, written=file.stat().st_mtime)
    step, told = _import(run)
    steps, notes = [step], list(told)
    model, made = "", []
    for model, step in project_models(run):  # noqa: B007 (the last one answers)
        steps.append(step)
    for step, of_notes, files in project_answers(run, model):
        steps.append(step)
        notes += of_notes
        made += files
    with reading(database) as session:
        # Also where every step is up to date.
        notes += notes_of(session, model, load_records(session))
    each_once = tuple(dict.fromkeys(notes))
    return ProjectRun(str(file), database, model, Rows(steps), tuple(made), each_once)


def _import(run: ProjectState) -> tuple[Step, tuple[str, ...]]:
    """The step, and the notes on the rows."""
    project, folder = run.project, run.folder
    init_database(run.database)
    found = import_files(
        run.database,
        [folder / name for name in project.files],
        dem=None if project.dem is None else folder / project.dem,
        land_cover=None if project.land_cover is None else folder / project.land_cover,
        update=project.update,
        given=Conventions(unusual=project.unusual),
    )
    counts = found.records
    kinds = {
        "paths": counts.paths,
        "profiles": counts.profiles,
        "events": counts.events,
        "speeds": counts.speeds,
    }
    changed = [f"{kind} {c.new + c.updated}" for kind, c in kinds.items() if c.new + c.updated]
    words = f"new or changed: {', '.join(changed)}" if changed else "no change"
    return Step("import", DONE if changed else UP_TO_DATE, words), found.notes
