"""A whole project, from its records to its bounds and pages; only what is out of date is done.

Nothing is kept besides the database: a step is up to date where what it would store is there
already, made of the same records. So a run that was interrupted goes on where it was.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal, get_type_hints

from pydantic import Field as Limits
from pydantic import create_model
from pydantic_core.core_schema import no_info_after_validator_function

from avahazard.effects.catalogue import definition
from avahazard.inference.model.choices import METHODS
from avahazard.inference.model.priors import GIVEN
from avahazard.inference.model.specification import Specification
from avahazard.notes import counted
from avahazard.records.conventions import Conventions
from avahazard.records.errors import AvahazardError
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.records.toml_document import Strict, read_toml
from avahazard.request import Field, Request, fields_of
from avahazard.results.base import Report, Rows, silent
from avahazard.results.calibration import Calibration
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.made import ProjectRun, Step
from avahazard.store.records import load_records
from avahazard.store.results import (
    COMPARISON,
    DIAGNOSIS,
    Kind,
    latest_calibration,
    latest_documents,
    latest_key,
    latest_result,
    list_models,
)
from avahazard.store.session import reading
from avahazard.workflow.add import add
from avahazard.workflow.by_path import PathWork, run_key
from avahazard.workflow.calibrate import asked_for, calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import init_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.export import export
from avahazard.workflow.hazard import hazard, hazard_work
from avahazard.workflow.import_files import import_files
from avahazard.workflow.report import write_report
from avahazard.workflow.requests import (
    CalibrateRequest,
    DiagnoseRequest,
    HazardRequest,
    ReportRequest,
    ZonesRequest,
)
from avahazard.workflow.stored import notes_of
from avahazard.workflow.zones import zones, zones_work

NAME = "avahazard.toml"
EXAMPLE = (
    'The least is: files = ["records"], the folder of paths.csv, profiles.csv and events.csv. '
    "docs/project.md has all keys."
)
StepName = Literal["compare", "diagnose", "hazard", "zones", "report", "export"]
Pair = Annotated[list[float], Limits(min_length=2, max_length=2)]
Name = Annotated[str, Limits(min_length=1, max_length=150)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelRequest(CalibrateRequest):
    """`[model]`: what `calibrate` is asked for, and the name of the model."""

    name: Name = "base"


@dataclass(frozen=True, slots=True, kw_only=True)
class RoundsRequest(DiagnoseRequest):
    """`[diagnose]`: what `diagnose` is asked for, and how often what it names is added."""

    add: bool = False
    rounds: Annotated[int, Limits(ge=1, le=9)] = 3


@dataclass(frozen=True, slots=True)
class TomlTable:
    """A table of the file: `keys` of a request, which is `base` where they are not given."""

    base: Request
    keys: tuple[str, ...]

    def __get_pydantic_core_schema__(self, request: Any, handler: Any) -> Any:
        told: dict[str, Any] = {
            key: (hint, None)
            for key, hint in get_type_hints(request, include_extras=True).items()
            if key in self.keys
        }
        told |= {f.name: (_value(f), None) for f in fields_of(request) if f.name in self.keys}
        form = create_model(request.__name__, __base__=Strict, **told)
        return no_info_after_validator_function(
            lambda read: replace(self.base, **{k: getattr(read, k) for k in read.model_fields_set}),
            handler.generate_schema(form),
        )


def _value(field: Field) -> Any:
    """The type of a key, with its limits and its name in the file."""
    option = field.option
    kind = field.kind if option.parse is None else dict[str, Pair]
    if kind in (int, float):
        within = Limits(gt=option.over, ge=option.least, le=option.most, allow_inf_nan=False)
        kind = Annotated[kind, within]
    kind = list[kind] if field.many else kind  # type: ignore[valid-type]
    return Annotated[kind, Limits(alias=field.name.rstrip("_"))]


MODEL = tuple(field.name for field in fields(ModelRequest))
YEARS = (100.0,)


class ReportSection(Strict):
    """`[report]`: the page to write."""

    file: str = "report.html"


class ExportSection(Strict):
    """`[export]`: the files to write, each for what its name ends in."""

    files: list[str] = Limits(default=["bounds.csv"])


class Project(Strict):
    """A whole project; files are beside `avahazard.toml` unless they are absolute."""

    files: Annotated[list[str], Limits(min_length=1)]
    database: str | None = None
    update: bool = False
    unusual: bool = False
    dem: str | None = None
    land_cover: str | None = None
    skip: list[StepName] = Limits(default=[])
    project: Annotated[
        ReportRequest, TomlTable(ReportRequest(), ("title", "author", "place", "date", "language"))
    ] = ReportRequest()
    model: Annotated[ModelRequest, TomlTable(ModelRequest(), MODEL)] = ModelRequest()
    diagnose: Annotated[
        RoundsRequest, TomlTable(RoundsRequest(), ("worlds", "seed", "add", "rounds"))
    ] = RoundsRequest()
    hazard: Annotated[
        HazardRequest,
        TomlTable(
            HazardRequest(return_periods=YEARS), ("return_periods", "volumes", "paths", "seed")
        ),
    ] = HazardRequest(return_periods=YEARS)
    zones: Annotated[ZonesRequest, TomlTable(ZonesRequest(), ("limits",))] = ZonesRequest()
    report: ReportSection = ReportSection()
    export: ExportSection = ExportSection()


def read_project(file: FilePath) -> Project:
    """Read the file of a project.

    Raises `AvahazardError` where there is no such file, or a value is missing, unknown or out of
    range.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise AvahazardError(
            f"The project {file} cannot be read: {error.strerror}.",
            f"Write {NAME} in this folder, or name another: avahazard run FILE. {EXAMPLE}",
        ) from error
    except UnicodeDecodeError as error:
        raise AvahazardError(f"{file} is not UTF-8.", "Save it as UTF-8.") from error
    return read_toml(str(file), text, Project, EXAMPLE)


def run_project(file: FilePath, database: str, report: Report = silent) -> ProjectRun:
    """Run the project of `file`, in its own database or else in `database`.

    Import, calibrate, compare, diagnose (and add what is named, if the file says so), hazard,
    zones, report, export. A stored model is never overwritten: where the records or the file have
    changed since, the next one is called NAME-2. Raises `AvahazardError` where the file is not that
    of a project, or a step could not be done; those before it stay done.
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
    kinds = {
        name: getattr(found.records, name) for name in ("paths", "profiles", "events", "speeds")
    }
    changed = [f"{kind} {c.new + c.updated}" for kind, c in kinds.items() if c.new + c.updated]
    words = f"new or changed: {', '.join(changed)}" if changed else "no change"
    return Step("import", DONE if changed else UP_TO_DATE, words), found.notes


DONE, UP_TO_DATE = "done", "up to date"


@dataclass(slots=True)
class ProjectState:
    """The project, where its files are, and its database.

    `fresh` as soon as a step has found something new; `written` is when the file of the project
    was (seconds, as of files).
    """

    project: Project
    folder: FilePath
    database: str
    report: Report
    fresh: bool = False
    written: float = 0.0


def stored_result(run: ProjectState, kind: Kind, model: str) -> dict[str, Any] | None:
    """What was found last by a model; None where nothing was."""
    with reading(run.database) as session:
        return latest_result(session, kind, model)


NAMED = "missing-effect"
"""The verdict on which an effect is added."""


def project_models(run: ProjectState) -> Iterator[tuple[str, Step]]:
    """Calibrate, compare, diagnose, and again with what was named; the last model answers."""
    wanted, skip = run.project, run.project.skip
    model, step = _calibrated(run)
    for round_ in range(wanted.diagnose.rounds + 1):
        yield model, step
        if "compare" not in skip:
            yield model, _compared(run, model)
        if "diagnose" in skip or not METHODS[wanted.model.method].knows_errors:
            return
        step, diagnosis = _diagnosed(run, model)
        yield model, step
        if not wanted.diagnose.add or diagnosis.verdict != NAMED:
            return
        if round_ < wanted.diagnose.rounds:
            model, step = _added(run, model, diagnosis.missing)


def _calibrated(run: ProjectState) -> tuple[str, Step]:
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
            and _prior_source(stored) == (wanted.prior_from or "")
            and {k: [p.mean, p.sd] for k, p in (stored.given_priors or {}).items()}
            == {k: list(pair) for k, pair in wanted.prior.items()}
            and wanted.chains == stored.chains
            and wanted.draws in (None, stored.draws)
        )

    known, free = _known(run, wanted.name, wanted.paths, fits)
    if known is not None:
        return known, Step(f"calibrate {known}", UP_TO_DATE, "")
    found = calibrate(run.database, free, wanted, run.report)
    run.fresh = True
    return free, Step(f"calibrate {free}", DONE, _converged(found))


def _prior_source(stored: Calibration) -> str:
    """The model or paths that the law's prior is from, as `prior_from` names them."""
    source = "" if stored.prior is None else stored.prior.source
    return "" if source.startswith(GIVEN) else source


def _added(run: ProjectState, parent: str, effects: tuple[str, ...]) -> tuple[str, Step]:
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
    run: ProjectState, name: str, paths: Sequence[str], fits: Callable[[Calibration], bool]
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
    words = counted(found.n_events, "event")
    return words if found.diagnostics.converged else f"{words}; its chains have NOT converged"


def _compared(run: ProjectState, model: str) -> Step:
    if stored_result(run, COMPARISON, model) is not None:
        return Step(f"compare {model}", UP_TO_DATE, "")
    found = compare(run.database, model, report=run.report)
    run.fresh = True
    error = found.held_out.runout.crps_m
    return Step(f"compare {model}", DONE, f"held-out error (CRPS) {error:.1f} m")


def _diagnosed(run: ProjectState, model: str) -> tuple[Step, Diagnosis]:
    wanted = run.project.diagnose
    document = stored_result(run, DIAGNOSIS, model)
    if document is not None and document["seed"] == wanted.seed:
        found = Diagnosis.from_dict(document)
        return Step(f"diagnose {model}", UP_TO_DATE, _verdict(found)), found
    found = diagnose_model(run.database, model, wanted, run.report)
    run.fresh = True
    return Step(f"diagnose {model}", DONE, _verdict(found)), found


def _verdict(found: Diagnosis) -> str:
    if found.cannot_tell:
        return f"{found.verdict}, as far as few data tell"
    return ": ".join([found.verdict, ", ".join(found.missing)]) if found.missing else found.verdict


def project_answers(run: ProjectState, model: str) -> Iterator[tuple[Step, list[str], list[str]]]:
    """Steps, their notes, and the files that they wrote."""
    project, folder = run.project, run.folder
    if "hazard" not in project.skip:
        yield _bounds(run, model)
    if "zones" not in project.skip and not METHODS[project.model.method].in_metres:
        yield _zones(run, model)
    if "report" not in project.skip:
        page = folder / project.report.file
        if _outdated(run, page):
            report = write_report(run.database, model, page, project.project, run.report)
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
    request = run.project.hazard
    work, _ = hazard_work(run.database, model, request)
    if (n := _paths_found(run, work)) is not None:
        return Step("hazard", UP_TO_DATE, counted(n, "path")), [], []
    found = hazard(run.database, model, request, run.report)
    run.fresh = True
    n = len({row.path_id for row in found.rows})
    return Step("hazard", DONE, counted(n, "path")), list(found.notes), []


def _zones(run: ProjectState, model: str) -> tuple[Step, list[str], list[str]]:
    limits = run.project.zones.limits
    file = run.folder / limits
    request = replace(
        run.project.zones,
        limits=str(file) if file.is_file() else limits,
        paths=run.project.hazard.paths,
    )
    work, _ = zones_work(run.database, model, request)
    if (n := _paths_found(run, work)) is not None:
        return Step("zones", UP_TO_DATE, counted(n, "path")), [], []
    found = zones(run.database, model, request, run.report)
    run.fresh = True
    return Step("zones", DONE, counted(len(found.rows), "path")), list(found.notes), []


def _paths_found(run: ProjectState, work: PathWork) -> int | None:
    """The paths of the last run of this kind; None where it hangs on something else than this."""
    with reading(run.database) as session:
        if latest_key(session, work.kind, work.model.model) != run_key(work):
            return None
        found = latest_documents(session, work.kind, work.model.model) or ()
        return len({row["path_id"] for row in found})


def _outdated(run: ProjectState, file: FilePath) -> bool:
    """Whether the file is missing, older than what it stands on, or something new was found.

    It stands on the database, and on the file of the project, which has its title and language.
    """
    if run.fresh or not file.is_file() or run.written > file.stat().st_mtime:
        return True
    database = FilePath(run.database)
    return database.is_file() and database.stat().st_mtime > file.stat().st_mtime
