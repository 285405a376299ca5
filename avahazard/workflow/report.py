"""The report of a stored model as one HTML file."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.scores import expected_records
from avahazard.effects.columns import EventColumns
from avahazard.hazard.future_events import classes_of
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.model.choices import BLOCK
from avahazard.inference.model.friction_model import LEAST_LOG_SCATTER
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, PLACE
from avahazard.inference.paper.calibration import recorded_elevation
from avahazard.inference.prediction import predict_stops
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.records.collection import (
    DEGREES,
    Event,
    Profile,
    Records,
    TerrainCrop,
    of_path,
    only_paths,
)
from avahazard.records.errors import AvahazardError
from avahazard.report.html import content as page
from avahazard.report.language import language_of, speaking
from avahazard.results.base import RATIO, Report, finite, silent
from avahazard.results.files import WrittenReport
from avahazard.results.hazard import HazardRow, PlaceQuantiles, ZonedPath
from avahazard.results.terrain import PERIOD_COLORS, TerrainRunout
from avahazard.store import results as store
from avahazard.store.records import load_terrain
from avahazard.store.session import Session, reading
from avahazard.whole_file import written_whole
from avahazard.workflow import friction as frictions
from avahazard.workflow.calibrate import show_model
from avahazard.workflow.compare import COORDINATES, RECORD_DRAWS, ladder_rows
from avahazard.workflow.flow import map_parts
from avahazard.workflow.hazard import knows_speeds, load_limits
from avahazard.workflow.listing import list_paths
from avahazard.workflow.next_step import latest_comparison, latest_diagnosis, next_step
from avahazard.workflow.path import alpha_beta_paths, describe_path, run_site
from avahazard.workflow.report_loop import QUANTILES, loop_view
from avahazard.workflow.requests import MapRequest, ReportRequest
from avahazard.workflow.stored import (
    limits_speed,
    load_parameter_draws,
    load_stored,
    notes_of_fit,
    surroundings,
)

ENDINGS = (".html", ".htm")


def write_report(
    database: str, name: str, file: FilePath, request: ReportRequest, report: Report = silent
) -> WrittenReport:
    """Write the report of the stored model `name` to `file`; an older one is replaced.

    It shows the latest comparison, diagnosis, bounds and zones, and says what is missing. Equal
    databases give equal files. Raises `AvahazardError` where there is no such model, its own
    effects are not given, or `file` cannot be written or is not the name of a page.
    """
    require_page(file)
    if not file.absolute().parent.is_dir():
        raise AvahazardError(f"There is no folder {file.parent}.", "Make the folder first.")
    from avahazard.report.html.page import render  # noqa: PLC0415 (plotly and jinja2 are slow)

    content = gather(database, name, request, report)
    with speaking(language_of(request.language)):
        text = render(content).encode("utf-8")
    try:
        with written_whole(file) as part:
            part.write_bytes(text)
    except OSError as error:
        raise AvahazardError(
            f"{file} cannot be written: {error.strerror}.", "Name another file: -o FILE.html."
        ) from error
    report("Writing the report", 1.0)
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


def require_page(file: FilePath) -> None:
    """Raise `AvahazardError` where `file` is not the name of a page."""
    if file.suffix.lower() not in ENDINGS:
        raise AvahazardError(
            f"{file} is not the name of a page.", f"It must end in {' or '.join(ENDINGS)}."
        )


def averaged_rows(session: Session, models: Sequence[str], name: str) -> list[HazardRow]:
    """The rows of the latest average that `name` is in; none without one."""
    runs = [store.latest_run(session, store.AVERAGE, model) for model in models]
    among = {run.id: run.model for run in runs if run and name in run.settings["weights"]}
    latest = among and store.latest_documents(session, store.AVERAGE, among[max(among)])
    return list(map(HazardRow.from_dict, latest or ()))


def gather(
    database: str, name: str, request: ReportRequest, report: Report = silent
) -> page.ReportContent:
    """Gather what the report of a stored model shows; raises as `load_stored`."""
    stored, records = load_stored(database, name, request.effect_files)
    with reading(database) as session:
        models = store.list_models(session)
        names = [model.name for model in models]
        comparisons = {n: found for n in names if (found := latest_comparison(session, n))}
        diagnoses = {n: told for n in names if (told := latest_diagnosis(session, n))}
        averages = averaged_rows(session, names, name)
        bounds = store.latest_by_path(session, store.BOUNDS, name)
        rows = list(map(HazardRow.from_dict, bounds)) or averages
        zones = list(map(ZonedPath.from_dict, store.latest_by_path(session, store.ZONES, name)))
        grounds = {
            profile.path_id: ground
            for profile in records.profiles
            if (ground := load_terrain(session, profile.path_id)) is not None
        }
    report("Writing the report", 0.07)
    apparent, _ = frictions.apparent_friction(stored)
    report("Writing the report", 0.1)
    events = event_views(only_paths(records, stored.paths).events, stored, apparent.mu)
    report("Writing the report", 0.14)
    baseline = alpha_beta_paths(database) if records.profiles else ()
    flows = flow_views(database, stored, records)
    paths = path_views(stored, records, events, rows, baseline, zones, grounds, flows)
    shown = {view.path.path_id for view in paths}
    report("Writing the report", 0.4)
    loop = loop_view(database, stored, models, comparisons, diagnoses)
    report("Writing the report", 0.9)
    model = next(model for model in models if model.name == name)
    there = {
        "profiles": records.profiles,
        "comparison": comparisons.get(name),
        "diagnosis": diagnoses.get(name),
        "rows": rows or flows,
        "zones": zones,
    }
    return page.ReportContent(
        model=show_model(database, name),
        draws={key: v.ravel() for key, v in load_parameter_draws(database, name).items()},
        paths=paths,
        events=events,
        n_speeds=sum(len(track.x) for track in stored.observations.speeds),
        covariates=unknown_columns(stored.columns),
        friction=frictions.friction_view(stored),
        densities=frictions.friction_densities(apparent.mu, stored.observations),
        summaries=[row for row in list_paths(database) if row.path_id in shown],
        ladder=ladder_rows(models, comparisons, {}),
        comparison=comparisons.get(name),
        diagnosis=diagnoses.get(name),
        rows=rows,
        averages=averages,
        records_changed=stored.records_changed,
        of_model=notes_of_fit(stored),
        calibrated_paths=stored.paths,
        effect_sha256=model.effect_sha256,
        physics={entry.key: entry.meaning for entry in stored.definitions},
        speed_limited=limits_speed(stored),
        versions=surroundings().versions,
        lacking=_lacking(stored, {key for key, value in there.items() if value}),
        loop=loop,
        cover=page.Cover(request.title, request.author, request.place, request.date),
        brief=request.brief,
    )


def _lacking(stored: FittedModel, there: set[str]) -> Mapping[str, Note]:
    """By key, what the report lacks; for the command line also how to make it."""
    name = stored.name
    lacking = {}
    if "profiles" not in there:
        lacking["paths"] = lacking["rows"] = Note("no_profiles")
    elif stored.specification.forward != BLOCK:
        lacking["zones"] = Note("map_instead", model=name)
        lacking |= {} if "rows" in there else {"rows": lacking["zones"]}
    elif "rows" not in there:
        lacking["rows"] = Note("no_bounds", model=name)
    if stored.sigma_m is not None:
        lacking["comparison"] = Note("one_scatter")
    elif "comparison" not in there:
        lacking["comparison"] = Note("not_compared", model=name)
    if not stored.knows_errors:
        lacking["diagnosis"] = Note("cannot_diagnose", method=stored.method)
    elif "diagnosis" not in there:
        lacking["diagnosis"] = Note("not_diagnosed", model=name)
    if stored.sigma_m is None and "profiles" in there and "zones" not in there | lacking.keys():
        lacking["zones"] = Note("no_zones" if knows_speeds(stored) else "no_drag_zones", model=name)
    return lacking


MOST_PLACES = 200
ANY_VOLUME_M3 = 1e4
"""Stands for the volume where the model has no use for it."""


def path_views(
    stored: FittedModel,
    records: Records,
    events: Sequence[page.EventView],
    rows: Sequence[HazardRow],
    alpha_beta: Sequence[TerrainRunout],
    zones: Sequence[ZonedPath],
    grounds: Mapping[str, TerrainCrop],
    flows: Mapping[str, page.FlowView],
) -> tuple[page.PathView, ...]:
    """The paths that the model was calibrated on or that have bounds, in the order of the store.

    `records` are all of the database, `events` those of the calibration; `grounds` and `flows` are
    the terrain and what flows there by path.
    """
    wanted = {*stored.paths, *(row.path_id for row in rows)}
    shown = [p for p in records.paths if not stored.paths or p.path_id in wanted]
    known = {site.path.path_id: site.smooth for site in stored.observations.sites}
    speeds = dict(_speeds(stored, records, rows))
    views = []
    for path in shown:
        path_id = path.path_id
        view = page.path_view(
            records,
            path_id,
            known.get(path_id),
            rows=[row for row in rows if row.path_id == path_id],
            speeds=speeds.get(path_id, []),
            alpha_beta=[row for row in alpha_beta if row.path_id == path_id],
            zones=next((zoned for zoned in zones if zoned.path_id == path_id), None),
        )
        if selected := tuple(e for e in events if e.path_id == path_id):
            view = replace(view, events=selected)
        own = of_path(records, path_id)
        if own.profiles and view.smooth is not None:
            (profile,) = own.profiles
            notes = describe_path(path, profile, view.smooth, own.events).notes
            plan = _plan(profile, grounds.get(path_id), flows.get(path_id))
            view = replace(view, notes=notes, plan=plan)
        views.append(view)
    return tuple(views)


def _speeds(
    model: FittedModel, records: Records, rows: Sequence[HazardRow]
) -> Iterator[tuple[str, list[page.SpeedLine]]]:
    """By path, for each of its rows: the row, x and speed of the block of median friction."""
    values = model.layout.effect_values(model.draws.mean(axis=0))
    for path_id in dict.fromkeys(row.path_id for row in rows):
        selected = [row for row in rows if row.path_id == path_id]
        volumes = np.array([row.volume_m3 or ANY_VOLUME_M3 for row in selected])
        events = tuple(Event("", path_id=path_id, volume_m3=size) for size in volumes.tolist())
        future = classes_of(replace(of_path(records, path_id), events=events), model.columns)
        friction = model.median_friction(volumes, future.columns)
        resistance = model.resistance(future.site, values)
        lines = []
        for row, mu in zip(selected, friction, strict=True):
            if row.p_not_released <= 0.5:
                found = run_site(future.site, float(mu), resistance).speeds
                places = np.array([[s.x_m, s.speed_m_s] for s in found])
                lines.append((row, *places.T))
        yield path_id, lines


def flow_views(database: str, model: FittedModel, records: Records) -> dict[str, page.FlowView]:
    """The annual chance on the terrain of paths by a flow model; empty for a model of the block."""
    if model.specification.forward == BLOCK:
        return {}
    limits = load_limits(MapRequest().limits)
    try:
        parts, _ = map_parts(database, model, records, MapRequest(), limits)
    except AvahazardError:  # such as records without dates, of which its notes tell
        return {}
    bands = ("chance_q05", "chance", "chance_q95")
    return {
        part.one.path.path_id: page.FlowView(
            part.bands["chance"],
            {t: PlaceQuantiles(*(part.runout(b, t) for b in bands)) for t in PERIOD_COLORS},
        )
        for part in parts
        if part.runs
    }


def _plan(
    profile: Profile, ground: TerrainCrop | None, flow: page.FlowView | None
) -> page.PlanView | None:
    """The path from above, by its own coordinates; None where it has none."""
    if profile.on_map is None:
        return None
    xy, crs = profile.on_map
    some = np.unique(np.linspace(0, len(profile.x_m) - 1, MOST_PLACES).round().astype(int))
    if ground is None or ground.crs != crs:
        ground = flow = None
    (east, north), system = xy[some].T, None if crs == DEGREES else crs or "?"
    return page.PlanView(profile.x_m[some], east, north, system, ground, flow)


def event_views(
    events: tuple[Event, ...], model: FittedModel, mu: Floats
) -> tuple[page.EventView, ...]:
    """The events of the model, in its order; `mu` `[n_events]` is their apparent friction."""
    observations, metres = model.observations, model.sigma_m is not None
    draws = _predicted(model)
    observed = observations.as_recorded(observations.observed)
    observed = recorded_elevation(observations) if metres else observed
    smooth = {site.path.path_id: site.smooth for site in observations.sites}
    reference = mu * np.exp(-frictions.from_reference(model))
    views = []
    for i, event in enumerate(events):
        known = bool(np.isfinite(draws[i]).all())
        kind = ELEVATION if metres and observations.kind[i] == PLACE else int(observations.kind[i])
        views.append(
            replace(
                page.event_view(event, smooth.get(event.path_id or "")),
                coordinate=RATIO if observations.in_ratio else COORDINATES[kind],
                observed_m=None if observations.kind[i] == LEFT else float(observed[i]),
                mu_reference=finite(reference[i]),
                predicted=tuple(np.quantile(draws[i], QUANTILES).tolist()) if known else None,
            )
        )
    return tuple(views)


def unknown_columns(columns: EventColumns) -> Mapping[str, int]:
    """For every column of the events that some lack, by how many."""
    lacking = {name: int(np.isnan(values).sum()) for name, values in columns.numbers.items()}
    lacking |= {name: int(np.sum(values == "")) for name, values in columns.texts.items()}
    return {name: n for name, n in lacking.items() if n}


def _predicted(model: FittedModel) -> Floats:
    """Draws `[n_events, n_draws]` of each record with its error."""
    # The very draws that `compare` scores.
    rng = generator(0, "compare")
    if model.sigma_m is None:
        return expected_records(model, RECORD_DRAWS, rng).draws
    # Its scatter is in metres of elevation, about the stop of the median friction.
    sigma = model.sigma_m[model.thinned(RECORD_DRAWS)]
    flat = model.draws.copy()
    flat[:, model.layout.scatter] = LEAST_LOG_SCATTER
    stops = predict_stops(replace(model, draws=flat), RECORD_DRAWS, rng)
    noise = sigma * rng.standard_normal(stops.elevation.shape)
    elevation = np.where(stops.left, stops.elevation, stops.elevation + noise)
    elevation[model.observations.kind == LENGTH] = np.nan
    return elevation
