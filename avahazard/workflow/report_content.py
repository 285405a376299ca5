"""What the report of a stored model shows, and what it lacks."""

from __future__ import annotations

from collections.abc import Mapping

from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.notes import Note
from avahazard.records.lookup import only_paths
from avahazard.records.plain import plain
from avahazard.report.html.content import Cover, ReportContent
from avahazard.report.language import language_of
from avahazard.results.base import Report, silent
from avahazard.results.diagnosis import Diagnosis
from avahazard.store.models import list_models
from avahazard.store.records import load_terrain
from avahazard.store.results import (
    BOUNDS,
    COMPARISON,
    DIAGNOSIS,
    ZONES,
    latest_documents,
    latest_result,
)
from avahazard.store.session import reading
from avahazard.workflow.alpha_beta import alpha_beta_paths
from avahazard.workflow.compare import stored_comparison
from avahazard.workflow.friction_views import friction_densities
from avahazard.workflow.ladder import ladder_rows
from avahazard.workflow.model_friction import apparent_friction, friction_view
from avahazard.workflow.models import show_model
from avahazard.workflow.provenance import surroundings
from avahazard.workflow.report_events import event_views, unknown_columns
from avahazard.workflow.report_loop import loop_view
from avahazard.workflow.report_paths import path_views
from avahazard.workflow.requests import ReportRequest
from avahazard.workflow.stored.model import load_parameter_draws, load_stored
from avahazard.workflow.stored.notes import notes_of_fit
from avahazard.workflow.stored.own_effects import own_effects


def gather(
    database: str,
    name: str,
    request: ReportRequest,
    report: Report = silent,
) -> ReportContent:
    """Gather what the report of a stored model shows.

    Raises:
        AvahazardError: there is no such model, or its own effects are not given.
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
        rows = latest_documents(session, BOUNDS, name) or []
        zones = latest_documents(session, ZONES, name) or []
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
    baseline = plain(alpha_beta_paths(database)) if records.profiles else []
    paths = path_views(stored, records, events, rows, baseline, zones, grounds)
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
        densities=plain(friction_densities(found.mu, stored.observations)),
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
