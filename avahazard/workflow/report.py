"""The report of a stored model as one HTML file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath

from avahazard.inference.fitted_model import FittedModel
from avahazard.notes import Note
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import only_paths
from avahazard.report.html.content import Cover, ReportContent
from avahazard.report.language import language_of
from avahazard.results.base import Report, silent
from avahazard.results.database import WrittenReport
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.hazard import HazardRow
from avahazard.results.zones import ZonedPath
from avahazard.store.records import load_terrain
from avahazard.store.results import (
    BOUNDS,
    COMPARISON,
    DIAGNOSIS,
    ZONES,
    latest_documents,
    latest_result,
    list_models,
)
from avahazard.store.session import reading
from avahazard.whole_file import put_in_place
from avahazard.workflow.alpha_beta import alpha_beta_paths
from avahazard.workflow.compare import ladder_rows, stored_comparison
from avahazard.workflow.effects import own_effects
from avahazard.workflow.friction import apparent_friction, friction_densities, friction_view
from avahazard.workflow.models import show_model
from avahazard.workflow.next_step import next_step
from avahazard.workflow.path import list_paths
from avahazard.workflow.report_loop import loop_view
from avahazard.workflow.report_paths import event_views, path_views, unknown_columns
from avahazard.workflow.requests import ReportRequest
from avahazard.workflow.stored import load_parameter_draws, load_stored, notes_of_fit, surroundings

ENDINGS = (".html", ".htm")


def write_report(
    database: str, name: str, file: FilePath, request: ReportRequest, report: Report = silent
) -> WrittenReport:
    """Write the report of the stored model `name` to `file`; an older one is replaced.

    Nothing is computed anew that a command stores: the report shows the latest comparison,
    diagnosis, bounds and zones, and says how to get what is missing. Equal databases give equal
    files. Raises `AvahazardError` where there is no such model, its own effects are not given, or
    `file` cannot be written or is not the name of a page.
    """
    if file.suffix.lower() not in ENDINGS:
        raise AvahazardError(
            f"{file} is not the name of a page.", f"It must end in {' or '.join(ENDINGS)}."
        )
    if not file.absolute().parent.is_dir():
        raise AvahazardError(f"There is no folder {file.parent}.", "Make the folder first.")
    from avahazard.report.html.page import render  # noqa: PLC0415 (plotly and jinja2 are slow)

    content = gather(database, name, request, report)
    text = render(content).encode("utf-8")
    whole = file.with_name(f".{file.name}.part")
    try:
        whole.write_bytes(text)
        put_in_place(whole, file)
    except OSError as error:
        whole.unlink(missing_ok=True)
        raise AvahazardError(
            f"{file} cannot be written: {error.strerror}.", "Name another file: -o FILE.html."
        ) from error
    report("Writing the report", 1.0, 1.0)
    return WrittenReport(
        model=name,
        file=str(file),
        bytes=len(text),
        n_paths=len(content.paths),
        n_events=len(content.events),
        lacking=tuple(dict.fromkeys(content.lacking.values())),
        notes=content.of_model,
        next=next_step(database, name, done=("report",)),
    )


def gather(
    database: str, name: str, request: ReportRequest, report: Report = silent
) -> ReportContent:
    """Gather what the report of a stored model shows.

    Raises `AvahazardError` where there is no such model, or its own effects are not given.
    """
    tongue = language_of(request.language)
    own = own_effects(database, name, request.effect_files)
    stored, records = load_stored(database, name, own)
    with reading(database) as session:
        models = list_models(session)
        comparisons = {
            model.name: stored_comparison(latest_result(session, COMPARISON, model.name))
            for model in models
        }
        diagnoses = {
            model.name: Diagnosis.from_dict(document)
            for model in models
            if (document := latest_result(session, DIAGNOSIS, model.name)) is not None
        }
        rows = [HazardRow.from_dict(d) for d in latest_documents(session, BOUNDS, name) or ()]
        zones = [ZonedPath.from_dict(d) for d in latest_documents(session, ZONES, name) or ()]
        grounds = {
            profile.path_id: ground
            for profile in records.profiles
            if (ground := load_terrain(session, profile.path_id)) is not None
        }
    report("Writing the report", 0.1, 1.0)
    found, _ = apparent_friction(stored)
    report("Writing the report", 0.3, 1.0)
    events = event_views(only_paths(records, stored.paths).events, stored, found.mu)
    report("Writing the report", 0.6, 1.0)
    baseline = alpha_beta_paths(database) if records.profiles else ()
    paths = path_views(stored, records, events, rows, baseline, zones, grounds)
    shown = {view.path.path_id for view in paths}
    report("Writing the report", 0.7, 1.0)
    loop = loop_view(database, stored, records, models, comparisons, diagnoses)
    report("Writing the report", 0.9, 1.0)
    calibration = show_model(database, name)
    model = next(model for model in models if model.name == name)
    return ReportContent(
        model=calibration,
        created=str(calibration.created),
        draws={key: v.ravel() for key, v in load_parameter_draws(database, name).items()},
        paths=paths,
        events=events,
        n_speeds=sum(len(track.x) for track in stored.observations.speeds),
        covariates=unknown_columns(stored.columns),
        friction=friction_view(stored),
        densities=friction_densities(found.mu, stored.observations),
        summaries=[row for row in list_paths(database) if row.path_id in shown],
        ladder=ladder_rows(models, comparisons, {}),
        comparison=comparisons[name],
        diagnosis=diagnoses.get(name),
        rows=rows,
        records_changed=stored.records_changed,
        of_model=notes_of_fit(stored),
        calibrated_paths=stored.paths,
        effect_sha256=model.effect_sha256,
        physics={entry.key: entry.meaning for entry in stored.definitions},
        speed_limited=any(entry.limits_speed for entry in stored.definitions),
        versions=surroundings().versions,
        lacking=_lacking(
            stored,
            profiles=bool(records.profiles),
            comparison=comparisons[name] is not None,
            diagnosis=name in diagnoses,
            rows=bool(rows),
            zones=bool(zones),
        ),
        loop=loop,
        cover=Cover(request.title, request.author, request.place, request.date),
        language=tongue,
        brief=request.brief,
    )


def _lacking(
    stored: FittedModel,
    *,
    profiles: bool,
    comparison: bool,
    diagnosis: bool,
    rows: bool,
    zones: bool,
) -> Mapping[str, Note]:
    """By key, what the report lacks and the command that makes it."""
    name = stored.name
    lacking = {}
    if not profiles:
        lacking["paths"] = lacking["rows"] = Note("no_profiles")
    elif not rows:
        lacking["rows"] = Note("no_bounds", model=name)
    if stored.sigma_m is not None:
        lacking["comparison"] = Note("one_scatter")
    elif not comparison:
        lacking["comparison"] = Note("not_compared", model=name)
    if not stored.knows_errors:
        lacking["diagnosis"] = Note("cannot_diagnose", method=stored.method)
    elif not diagnosis:
        lacking["diagnosis"] = Note("not_diagnosed", model=name)
    if profiles and not zones:
        lacking["zones"] = Note("no_zones", model=name)
    return lacking
