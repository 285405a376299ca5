"""The answers of a project by its last model: bounds, zones, report, files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Any

from avahazard.message import counted
from avahazard.report.html.content import Cover
from avahazard.results.project import Step
from avahazard.store.results import BOUNDS, ZONES, RunKind, latest_documents, latest_key
from avahazard.store.session import reading
from avahazard.workflow.export import export
from avahazard.workflow.hazard import HazardQuestion, hazard, hazard_work
from avahazard.workflow.project.state import DONE, UP_TO_DATE, ProjectState
from avahazard.workflow.report import write_report
from avahazard.workflow.stored.by_path import run_key
from avahazard.workflow.zones import ZonesQuestion, zones, zones_work


def project_answers(run: ProjectState, model: str) -> Iterator[tuple[Step, list[str], list[str]]]:
    """Steps, their notes, and the files that they wrote."""
    project, folder = run.project, run.folder
    if "hazard" not in project.skip:
        yield _bounds(run, model)
    if "zones" not in project.skip and project.model.method != "metropolis":
        yield _zones(run, model)
    if "report" not in project.skip:
        page = folder / project.report.file
        if _outdated(run, page):
            told = project.project
            cover = Cover(told.title, told.author, told.place, told.date)
            report = write_report(
                run.database,
                model,
                page,
                cover=cover,
                language=told.language,
                report=run.report,
            )
            yield Step("report", DONE, page.name), [*report.lacking, *report.notes], [str(page)]
        else:
            yield Step("report", UP_TO_DATE, page.name), [], [str(page)]
    if "export" not in project.skip and "hazard" not in project.skip:
        for name in project.export.files:
            file = folder / name
            notes: list[str] = []
            state = UP_TO_DATE
            if _outdated(run, file):
                notes = list(export(run.database, model, file).notes)
                state = DONE
            yield Step("export", state, file.name), notes, [str(file)]


def _bounds(run: ProjectState, model: str) -> tuple[Step, list[str], list[str]]:
    wanted = run.project.hazard
    asked: dict[str, Any] = {
        "return_periods": wanted.return_periods,
        "volumes": wanted.volumes,
        "paths": wanted.paths,
        "seed": wanted.seed,
    }
    work = hazard_work(run.database, model, HazardQuestion(**asked))
    if _is_latest(run, BOUNDS, model, run_key(*work)):
        n = len({row["path_id"] for row in _found(run, BOUNDS, model) or ()})
        return Step("hazard", UP_TO_DATE, counted(n, "path")), [], []
    found = hazard(run.database, model, report=run.report, **asked)
    run.fresh = True
    n = len({row.path_id for row in found.rows})
    return Step("hazard", DONE, counted(n, "path")), list(found.notes), []


def _zones(run: ProjectState, model: str) -> tuple[Step, list[str], list[str]]:
    limits = run.project.zones.limits
    file = run.folder / limits
    asked: dict[str, Any] = {
        "limits": str(file) if file.is_file() else limits,
        "paths": run.project.hazard.paths,
    }
    work = zones_work(run.database, model, ZonesQuestion(**asked))
    if _is_latest(run, ZONES, model, run_key(*work)):
        n = len(_found(run, ZONES, model) or ())
        return Step("zones", UP_TO_DATE, counted(n, "path")), [], []
    found = zones(run.database, model, report=run.report, **asked)
    run.fresh = True
    return Step("zones", DONE, counted(len(found.rows), "path")), list(found.notes), []


def _is_latest(run: ProjectState, kind: RunKind, model: str, key: str) -> bool:
    """Whether the last run of this kind hangs on the same as one of this key would."""
    with reading(run.database) as session:
        return latest_key(session, kind, model) == key


def _found(run: ProjectState, kind: RunKind, model: str) -> list[dict[str, Any]] | None:
    with reading(run.database) as session:
        return latest_documents(session, kind, model)


def _outdated(run: ProjectState, file: FilePath) -> bool:
    """Whether the file is missing, older than what it stands on, or something new was found.

    It stands on the database, and on the file of the project, which has its title and language.
    """
    if run.fresh or not file.is_file() or run.written > file.stat().st_mtime:
        return True
    database = FilePath(run.database)
    return database.is_file() and database.stat().st_mtime > file.stat().st_mtime
