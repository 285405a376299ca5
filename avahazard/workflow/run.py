"""A whole project, from its records to its bounds and pages; only what is out of date is done.

Nothing is kept besides the database: a step is up to date where what it would store is there
already, made of the same records. So a run that was interrupted goes on where it was.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory
from typing import Annotated, Any, Literal, get_type_hints

from pydantic import Field as Limits
from pydantic import create_model
from pydantic_core.core_schema import no_info_after_validator_function

from avahazard.inference.model.choices import METHODS
from avahazard.notes import Note, counted
from avahazard.records.collection import data_fingerprint, only_paths
from avahazard.records.conventions import Decimal, Order
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.records.toml_document import Strict, read_toml
from avahazard.request import Field, Request, fields_of
from avahazard.results.base import Report, Rows, silent
from avahazard.results.calibration import Calibration
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.files import ProjectRun, Step
from avahazard.store import results as store
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow import requests
from avahazard.workflow.by_path import PathWork
from avahazard.workflow.calibrate import add, calibrate, request_document
from avahazard.workflow.compare import compare
from avahazard.workflow.database import database_status, import_files, init_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.export import ending_of, export
from avahazard.workflow.hazard import (
    NoDragError,
    hazard,
    hazard_work,
    load_limits,
    zones,
    zones_work,
)
from avahazard.workflow.next_step import latest_diagnosis, next_step
from avahazard.workflow.report import require_page, write_report
from avahazard.workflow.stored import notes_of

NAME = "avahazard.toml"
EXAMPLE = (
    'The least is: files = ["records"], the folder of paths.csv, profiles.csv and events.csv. '
    "docs/project.md has all keys."
)
AS_KEYS = "Options of import are keys of the file of the project: update, decimal, dates, unknown."
StepName = Literal["compare", "diagnose", "hazard", "zones", "report", "export"]
Pair = Annotated[list[float], Limits(min_length=2, max_length=2)]
Name = Annotated[str, Limits(min_length=1, max_length=150)]


class ModelRequest(requests.CalibrateRequest):
    """`[model]`: what `calibrate` is asked for, and the name of the model."""

    name: Name = "base"


class RoundsRequest(requests.DiagnoseRequest):
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
    decimal: Decimal | None = None
    dates: Order | None = None
    unknown: list[str] = Limits(default=[])
    dem: str | None = None
    land_cover: str | None = None
    skip: list[StepName] = Limits(default=[])
    project: Annotated[
        requests.ReportRequest,
        TomlTable(requests.ReportRequest(), ("title", "author", "place", "date", "language")),
    ] = requests.ReportRequest()
    model: Annotated[ModelRequest, TomlTable(ModelRequest(), MODEL)] = ModelRequest()
    diagnose: Annotated[RoundsRequest, TomlTable(RoundsRequest(), ("seed", "add", "rounds"))] = (
        RoundsRequest()
    )
    hazard: Annotated[
        requests.HazardRequest,
        TomlTable(
            requests.HazardRequest(return_periods=YEARS),
            ("return_periods", "volumes", "paths", "seed"),
        ),
    ] = requests.HazardRequest(return_periods=YEARS)
    zones: Annotated[
        requests.ZonesRequest, TomlTable(requests.ZonesRequest(), ("limits", "no_drag"))
    ] = requests.ZonesRequest()
    report: ReportSection = ReportSection()
    export: ExportSection = ExportSection()


def read_project(file: FilePath) -> Project:
    """Read the file of a project. Raises `AvahazardError` where it is not one."""
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


DONE, UP_TO_DATE, TO_DO, LEFT_OUT = "done", "up to date", "to do", "left out"
NAMED = "missing-effect"
"""The verdict on which an effect is added."""


def run_project(
    file: FilePath, database: str, request: requests.RunRequest, report: Report = silent
) -> ProjectRun:
    """Run the project of `file`, in its own database or else in `database`.

    A stored model is never overwritten: where the records or the file have changed since, the next
    one is called NAME-2. A dry run says which steps are to do, as far as that does not hang on what
    an earlier one finds. Raises `AvahazardError` where the file is not that of a project, or a step
    could not be done; those before it stay done.
    """
    project = read_project(file)
    folder = file.absolute().parent
    named = project.database
    if named is not None:
        database = named if "://" in named else str(folder / named)
    run = RunningProject(project, folder, database, request, report, file.stat().st_mtime)
    run.check()
    if request.dry_run:
        return _dry_run(run, file)
    run.import_records()
    model = run.models()
    run.answers(model)
    with reading(database) as session:
        # Also where every step is up to date.
        run.notes += notes_of(store.load_model(session, model), load_records(session))
    done = [name for name in ("hazard", "report") if name not in project.skip]
    return run.result(file, model, next_step(database, model, done))


def _dry_run(run: RunningProject, file: FilePath) -> ProjectRun:
    """What is to do; a missing database counts as an empty one."""
    named = run.database
    with TemporaryDirectory() as folder:
        try:
            database_status(named)
        except AvahazardError:
            run.database = str(FilePath(folder) / "empty.db")
            init_database(run.database)
        run.import_records()
        model = run.models()
        run.answers(model)
    run.database = named
    return run.result(file, model)


@dataclass(slots=True)
class RunningProject:
    """A project, where its files are, its database, and what has been done of it so far.

    `fresh` as soon as a step has found something new, or is to do; `written` is when the file of
    the project was (seconds, as of files).
    """

    project: Project
    folder: FilePath
    database: str
    request: requests.RunRequest
    report: Report
    written: float
    fresh: bool = False
    steps: list[Step] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    files: list[str] = field(default_factory=list)

    def to_do(self, step: str, stored: str | None) -> bool:
        """Whether to do a step now: not where it is up to date, nor in a dry run.

        `stored` is in words what there is of it already, None where that is out of date.
        """
        if stored is not None and not self.everything:
            self.steps.append(Step(step, UP_TO_DATE, stored))
            return False
        if self.request.dry_run:
            self.fresh = True
            self.steps.append(Step(step, TO_DO, ""))
        return not self.request.dry_run

    def done(self, step: str, found: str, notes: Sequence[str] = ()) -> None:
        """A step that found something new."""
        self.fresh = True
        self.steps.append(Step(step, DONE, found))
        self.notes += notes

    @property
    def everything(self) -> bool:
        """Whether no step is up to date, whatever is stored."""
        return self.request.force or (self.request.dry_run and self.fresh)

    def result(self, file: FilePath, model: str, step: Note | None = None) -> ProjectRun:
        """What has been done of the project of `file`, and the step to do then."""
        notes, files = tuple(dict.fromkeys(self.notes)), tuple(self.files)
        return ProjectRun(str(file), self.database, model, Rows(self.steps), files, notes, step)

    @property
    def limits(self) -> str:
        """The limits of zones: a file beside the project, or a preset."""
        file = self.folder / self.project.zones.limits
        return str(file) if file.is_file() else self.project.zones.limits

    def check(self) -> None:
        """Raise `AvahazardError` for values of the file that no later step could use."""
        require_page(self.folder / self.project.report.file)
        for name in self.project.export.files:
            ending_of(self.folder / name)
        load_limits(self.limits)

    def import_records(self) -> None:
        """Import what the file names."""
        project, folder = self.project, self.folder
        # A dry run may look at a database that it must not make.
        if not self.request.dry_run:
            init_database(self.database)
        asked = requests.ImportRequest(
            dem=None if project.dem is None else folder / project.dem,
            land_cover=None if project.land_cover is None else folder / project.land_cover,
            update=project.update or self.request.update,
            dry_run=self.request.dry_run,
            **{key: getattr(project, key) for key in ("unusual", "decimal", "dates", "unknown")},
        )
        try:
            found = import_files(self.database, [folder / name for name in project.files], asked)
        except RejectedRows as error:
            error.hint = f"{error.hint} {AS_KEYS}"
            raise
        counts = {f.name: getattr(found.records, f.name) for f in fields(found.records)}
        changed = [f"{kind} {c.new + c.updated}" for kind, c in counts.items() if c.new + c.updated]
        words = f"new or changed: {', '.join(changed)}" if changed else "no change"
        self.fresh = bool(changed)
        state = UP_TO_DATE if not changed else TO_DO if found.dry_run else DONE
        self.steps.append(Step("import", state, words))
        self.notes += found.notes

    def models(self) -> str:
        """Calibrate, compare, diagnose, and again with what was named; the last model answers."""
        wanted, skip = self.project, self.project.skip
        model = self.calibrated()
        for round_ in range(wanted.diagnose.rounds + 1):
            if "compare" not in skip:
                self.compared(model)
            if "diagnose" in skip or not METHODS[wanted.model.method].knows_errors:
                return model
            diagnosis = self.diagnosed(model)
            if diagnosis is None or not wanted.diagnose.add or diagnosis.verdict != NAMED:
                return model
            if round_ < wanted.diagnose.rounds:
                model = self.added(model, diagnosis.missing)
        return model

    def calibrated(self) -> str:
        """The model of the file, on the records as they are."""
        wanted = self.project.model
        asked = request_document(wanted)
        return self._model(
            "calibrate",
            wanted.name,
            fits=lambda stored: stored.settings.get("request") == asked,
            made=lambda free: calibrate(self.database, free, wanted, self.report),
        )

    def added(self, parent: str, effects: tuple[str, ...]) -> str:
        """The child of a model with the effects that its diagnosis named."""
        return self._model(
            "add",
            "+".join((parent, *effects)),
            fits=lambda stored: stored.parent == parent and set(effects) <= set(stored.effects),
            made=lambda free: add(self.database, parent, effects, free, report=self.report),
        )

    def _model(
        self,
        step: str,
        name: str,
        fits: Callable[[store.StoredModel], bool],
        made: Callable[[str], Calibration],
    ) -> str:
        """The latest model NAME or NAME-n that fits, on today's records; else a new one."""
        with reading(self.database) as session:
            models = {model.name: model for model in store.list_models(session)}
            records = load_records(session)
        near = [
            model
            for n, model in models.items()
            if (n == name or n.removeprefix(f"{name}-").isdigit()) and fits(model)
        ]
        today = data_fingerprint(only_paths(records, self.project.model.paths)) if near else ""
        right = [one.name for one in near if one.result["data_fingerprint"] == today]
        free = store.free_name(name, models)
        chosen = right[-1] if right and not self.everything else free
        if self.to_do(f"{step} {chosen}", None if chosen == free else ""):
            found = made(free)
            bad = "" if found.diagnostics.converged else "; its chains have NOT converged"
            self.done(f"{step} {free}", counted(found.n_events, "event") + bad)
        return chosen

    def compared(self, model: str) -> None:
        """The comparison of a model."""
        with reading(self.database) as session:
            stored = store.latest_result(session, store.COMPARISON, model)
        if self.to_do(f"compare {model}", None if stored is None else ""):
            found = compare(self.database, model, report=self.report)
            error = found.held_out.runout.crps_m
            self.done(f"compare {model}", f"held-out error (CRPS) {error:.1f} m")

    def diagnosed(self, model: str) -> Diagnosis | None:
        """The diagnosis of a model; None where a dry run leaves it open."""
        wanted = self.project.diagnose
        with reading(self.database) as session:
            found = latest_diagnosis(session, model)
        if self.everything or (found and found.seed != wanted.seed):
            found = None
        if self.to_do(f"diagnose {model}", None if found is None else _verdict(found)):
            found = diagnose_model(self.database, model, wanted, self.report)
            self.done(f"diagnose {model}", _verdict(found))
        return found

    def answers(self, model: str) -> None:
        """Bounds, zones, report and exports by a model."""
        project, folder = self.project, self.folder
        if "hazard" not in project.skip:
            work = partial(hazard_work, self.database, model, project.hazard)
            if self.to_do("hazard", self._paths_found(work)):
                bounds = hazard(self.database, model, project.hazard, self.report)
                n = len({row.path_id for row in bounds.rows})
                self.done("hazard", counted(n, "path"), bounds.notes)
        if "zones" not in project.skip and not METHODS[project.model.method].in_metres:
            paths = project.hazard.paths
            request = replace(project.zones, paths=paths, limits=self.limits)
            try:
                work = partial(zones_work, self.database, model, request)
                if self.to_do("zones", self._paths_found(work)):
                    along = zones(self.database, model, request, self.report)
                    self.done("zones", counted(len(along.rows), "path"), along.notes)
            except NoDragError as error:
                self.steps.append(Step("zones", LEFT_OUT, ""))
                self.notes.append(f"{error.message} To accept it: no_drag = true in [zones].")
        fresh, page = self.fresh, folder / project.report.file
        if "report" not in project.skip and self.to_do("report", self._written(page, fresh)):
            report = write_report(self.database, model, page, project.project, self.report)
            self.done("report", page.name, (*report.lacking, *report.notes))
        if "export" not in project.skip and "hazard" not in project.skip:
            for file in (folder / name for name in project.export.files):
                if self.to_do("export", self._written(file, fresh)):
                    self.done("export", file.name, export(self.database, model, file).notes)

    def _paths_found(self, plan: Callable[[], tuple[PathWork, Any]]) -> str | None:
        """The paths of the last run of this kind, where it hangs on the same as this."""
        if self.everything:  # the model may be one that is still to be made
            return None
        work, _ = plan()
        with reading(self.database) as session:
            run = store.latest_run(session, work.kind, work.model.model)
            if run is None or run.key != work.key:
                return None
            n_paths = sum(one.failed is None for one in store.read_run(session, run.id))
        return counted(n_paths, "path")

    def _written(self, file: FilePath, fresh: bool) -> str | None:
        """The name of a file that is as new as what it stands on; `fresh`: there is news.

        It stands on the database, and on the file of the project, which has its title and language.
        """
        self.files.append(str(file))
        if fresh or not file.is_file():
            return None
        database, made = FilePath(self.database), file.stat().st_mtime
        if self.written > made or (database.is_file() and database.stat().st_mtime > made):
            return None
        return file.name


def _verdict(found: Diagnosis) -> str:
    if found.cannot_tell:
        return f"{found.verdict}, as far as few data tell"
    return f"{found.verdict}: {', '.join(found.missing)}".removesuffix(": ")
