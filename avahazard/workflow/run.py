"""A whole project, from its records to its bounds and pages; only what is out of date is done.

Nothing is kept besides the database: a step is up to date where what it would store is there
already, made of the same records. So a run that was interrupted goes on where it was.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path as FilePath

from avahazard.effects.catalogue import definition
from avahazard.inference.model.specification import Specification
from avahazard.inference.samplers.calibrate import N_CHAINS
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.results.base import Rows
from avahazard.results.calibration import Calibration
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.project import ProjectRun, Step
from avahazard.store.calibrations import latest_calibration
from avahazard.store.models import list_models
from avahazard.store.records import load_records
from avahazard.store.results import BOUNDS, COMPARISON, DIAGNOSIS, ZONES, Kind, latest_result
from avahazard.store.session import reading
from avahazard.workflow.add import add
from avahazard.workflow.calibrate import asked_for, calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import init_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.export import export
from avahazard.workflow.hazard import hazard
from avahazard.workflow.import_files import import_files
from avahazard.workflow.project_file import Project, read_project
from avahazard.workflow.report import write_report
from avahazard.workflow.zones import zones

Report = Callable[[str, float, float], None]
DONE, UP_TO_DATE = "done", "up to date"
NAMED = "missing-effect"
"""The verdict on which an effect is added."""


@dataclass(slots=True)
class _Run:
    """A run under way: `fresh` as soon as a step has found something new."""

    project: Project
    folder: FilePath
    database: str
    report: Report
    fresh: bool = False


def run_project(
    file: FilePath,
    database: str,
    report: Report = lambda _what, _done, _total: None,
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
    run = _Run(project, folder, database, report)
    steps = [_import(run)]
    model, notes, made = "", [], []
    for model, step in _models(run):  # noqa: B007 (the last one answers)
        steps.append(step)
    for step, of_notes, files in _answers(run, model):
        steps.append(step)
        notes += of_notes
        made += files
    return ProjectRun(str(file), database, model, Rows(steps), tuple(made), tuple(notes))


def _import(run: _Run) -> Step:
    project, folder = run.project, run.folder
    init_database(run.database)
    found = import_files(
        run.database,
        [folder / name for name in project.files],
        dem=None if project.dem is None else folder / project.dem,
        land_cover=None if project.land_cover is None else folder / project.land_cover,
        update=project.update,
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
    return Step("import", DONE if changed else UP_TO_DATE, words)


def _models(run: _Run) -> Iterator[tuple[str, Step]]:
    """Calibrate, compare, diagnose, and again with what was named; the last model answers."""
    wanted, skip = run.project, run.project.skip
    model, step = _calibrated(run)
    for round_ in range(wanted.diagnose.rounds + 1):
        yield model, step
        if "compare" not in skip:
            yield model, _compared(run, model)
        if "diagnose" in skip or wanted.model.method != "marginal":
            return
        step, diagnosis = _diagnosed(run, model)
        yield model, step
        if not wanted.diagnose.add or diagnosis.verdict != NAMED:
            return
        if round_ < wanted.diagnose.rounds:
            model, step = _added(run, model, diagnosis.missing)


def _calibrated(run: _Run) -> tuple[str, Step]:
    """The model of the file, on the records as they are."""
    wanted = run.project.model
    asked = asked_for(Specification(), [definition(key) for key in wanted.without])

    def fits(stored: Calibration) -> bool:
        return (
            stored.parent is None
            and (stored.law, stored.scatter, stored.distribution, stored.tails)
            == (wanted.law, wanted.scatter, wanted.distribution, wanted.tails)
            and (stored.method, stored.seed) == (wanted.method, wanted.seed)
            and set(stored.effects) == set(wanted.with_) - set(wanted.without)
            and stored.centrifugal == asked.centrifugal
            and wanted.chains in (None, stored.chains)
            and wanted.draws in (None, stored.draws)
        )

    known, free = _known(run, wanted.name, wanted.paths, fits)
    if known is not None:
        return known, Step(f"calibrate {known}", UP_TO_DATE, "")
    found = calibrate(
        run.database,
        free,
        law=wanted.law,
        scatter=wanted.scatter,
        distribution=wanted.distribution,
        method=wanted.method,
        tails=wanted.tails,
        with_=wanted.with_,
        without=wanted.without,
        paths=wanted.paths,
        chains=wanted.chains or N_CHAINS,
        draws=wanted.draws,
        seed=wanted.seed,
        report=run.report,
    )
    run.fresh = True
    return free, Step(f"calibrate {free}", DONE, _converged(found))


def _added(run: _Run, parent: str, effects: tuple[str, ...]) -> tuple[str, Step]:
    """The child of a model with the effects that its diagnosis named."""

    def fits(stored: Calibration) -> bool:
        return stored.parent == parent and set(effects) <= set(stored.effects)

    name = f"{parent}+{'+'.join(effects)}"
    known, free = _known(run, name, run.project.model.paths, fits)
    if known is not None:
        return known, Step(f"add {known}", UP_TO_DATE, "")
    found = add(run.database, parent, effects, free, report=run.report)
    run.fresh = True
    return free, Step(f"add {free}", DONE, _converged(found))


def _known(
    run: _Run, name: str, paths: list[str], fits: Callable[[Calibration], bool]
) -> tuple[str | None, str]:
    """The latest model NAME or NAME-n that fits and stands on today's records, and a free name."""
    with reading(run.database) as session:
        records = only_paths(load_records(session), paths)
        names = [model.name for model in list_models(session)]
        stored = {
            n: Calibration.from_dict(latest_calibration(session, n).result)
            for n in names
            if n == name or n.removeprefix(f"{name}-").isdigit()
        }
    today = data_fingerprint(records)
    right = [n for n, one in stored.items() if one.data_fingerprint == today and fits(one)]
    free, k = name, 2
    while free in names:
        free, k = f"{name}-{k}", k + 1
    return (right[-1] if right else None), free


def _converged(found: Calibration) -> str:
    words = f"{found.n_events} events"
    return words if found.diagnostics.converged else f"{words}; its chains have NOT converged"


def _compared(run: _Run, model: str) -> Step:
    if _stored(run, COMPARISON, model) is not None:
        return Step(f"compare {model}", UP_TO_DATE, "")
    found = compare(run.database, model, report=run.report)
    run.fresh = True
    error = found.held_out.runout.crps_m
    return Step(f"compare {model}", DONE, f"held-out error (CRPS) {error:.1f} m")


def _diagnosed(run: _Run, model: str) -> tuple[Step, Diagnosis]:
    wanted = run.project.diagnose
    document = _stored(run, DIAGNOSIS, model)
    if document is not None and document["seed"] == wanted.seed:
        found = Diagnosis.from_dict(document)
        return Step(f"diagnose {model}", UP_TO_DATE, _verdict(found)), found
    found = diagnose_model(
        run.database, model, n_worlds=wanted.worlds, seed=wanted.seed, report=run.report
    )
    run.fresh = True
    return Step(f"diagnose {model}", DONE, _verdict(found)), found


def _verdict(found: Diagnosis) -> str:
    return ": ".join([found.verdict, ", ".join(found.missing)]) if found.missing else found.verdict


def _answers(run: _Run, model: str) -> Iterator[tuple[Step, list[str], list[str]]]:
    """Steps, their notes, and the files that they wrote."""
    project, folder = run.project, run.folder
    if "hazard" not in project.skip:
        yield _bounds(run, model)
    if "zones" not in project.skip and project.model.method != "metropolis":
        yield _zones(run, model)
    if "report" not in project.skip:
        page = folder / project.report.file
        if _outdated(run, page):
            report = write_report(run.database, model, page, report=run.report)
            yield Step("report", DONE, page.name), list(report.lacking), [str(page)]
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


def _bounds(run: _Run, model: str) -> tuple[Step, list[str], list[str]]:
    wanted = run.project.hazard
    rows = _stored(run, BOUNDS, model)
    asked = {("T", float(t)) for t in wanted.return_periods}
    asked |= {("V", float(v)) for v in wanted.volumes}
    there = {
        ("T", row["return_period_years"]) if row["return_period_years"] else ("V", row["volume_m3"])
        for row in rows or ()
    }
    paths = {row["path_id"] for row in rows or ()}
    if rows and there == asked and (not wanted.paths or paths == set(wanted.paths)):
        return Step("hazard", UP_TO_DATE, f"{len(paths)} paths"), [], []
    found = hazard(
        run.database,
        model,
        return_periods=wanted.return_periods,
        volumes=wanted.volumes,
        paths=wanted.paths,
        seed=wanted.seed,
        report=run.report,
    )
    run.fresh = True
    n = len({row.path_id for row in found.rows})
    return Step("hazard", DONE, f"{n} paths"), list(found.notes), []


def _zones(run: _Run, model: str) -> tuple[Step, list[str], list[str]]:
    limits = run.project.zones.limits
    file = run.folder / limits
    name = str(file) if file.is_file() else limits
    stored = _stored(run, ZONES, model)
    if stored and not run.fresh and all(path["limits"] == name for path in stored):
        return Step("zones", UP_TO_DATE, f"{len(stored)} paths"), [], []
    found = zones(run.database, model, limits=name, paths=run.project.hazard.paths)
    run.fresh = True
    return Step("zones", DONE, f"{len(found.rows)} paths"), list(found.notes), []


def _stored(run: _Run, kind: Kind, model: str):  # type: ignore[no-untyped-def, type-arg]
    with reading(run.database) as session:
        return latest_result(session, kind, model)


def _outdated(run: _Run, file: FilePath) -> bool:
    """Whether the file is missing, older than the database, or something new was found."""
    if run.fresh or not file.is_file():
        return True
    database = FilePath(run.database)
    return database.is_file() and database.stat().st_mtime > file.stat().st_mtime
