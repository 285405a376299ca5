"""Runouts, speeds, pressures and zones per path, by a stored model; how often which volume is."""

import hashlib
import shlex
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.effects.catalogue import catalogue
from avahazard.hazard.frequency import (
    Frequencies,
    VolumeFrequency,
    known_volumes,
    return_volume,
    volume_frequencies,
)
from avahazard.hazard.path_hazard import path_hazard
from avahazard.hazard.rows import Scenario, Weighted, path_rows
from avahazard.hazard.volume_source import VolumeSource
from avahazard.hazard.zones import PRESETS, ZoneSystem, path_zones, read_limits
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.model.layout import TRACK_SCATTER_NAME
from avahazard.inference.prediction import extrapolation
from avahazard.notes import Note, placed
from avahazard.records.collection import find_path, no_profiles
from avahazard.records.errors import AvahazardError
from avahazard.report.model_tables import failing_speeds
from avahazard.report.picture import require_picture
from avahazard.request import many
from avahazard.results import hazard as results
from avahazard.results.base import Report, Rows, silent
from avahazard.store.records import load_records
from avahazard.store.results import AVERAGE, BOUNDS, ZONES, read_run
from avahazard.store.session import reading
from avahazard.workflow.by_path import PathTask, PathWork, run_paths
from avahazard.workflow.next_step import latest_comparison
from avahazard.workflow.requests import HazardRequest, VolumesRequest, ZonesRequest
from avahazard.workflow.stored import (
    limits_speed,
    load_for_paths,
    load_stored,
    notes_of_fit,
    records_of,
    require_friction_scatter,
    require_unchanged,
)

DEFAULT_RETURN_PERIOD = 100.0


@dataclass(frozen=True, slots=True)
class HazardRun:
    """A run of `hazard` that is stored, with notes for people; `failed` are reasons by path."""

    database: str
    run: int
    n_rows: int
    notes: tuple[Note, ...]
    failed: dict[str, str]

    def rows(self) -> Iterator[results.HazardRow]:
        """Its rows as the database has them, a few in memory at a time."""
        return (row for row in self.documents() if isinstance(row, results.HazardRow))

    def documents(self) -> Iterator[results.HazardRow | dict[str, Any]]:
        """What `--json` prints: its rows, and in their place why a path failed."""
        with reading(self.database) as session:
            for found in read_run(session, self.run):
                if found.failed is not None:
                    yield results.failed_document(found.path_id, found.failed)
                yield from map(results.HazardRow.from_dict, found.documents)


def hazard(
    database: str, names: str | Sequence[str], request: HazardRequest, report: Report = silent
) -> results.Hazard:
    """As `run_hazard`, with all rows in memory."""
    run = run_hazard(database, names, request, report)
    return results.Hazard(Rows(run.rows()), run.notes)


def run_hazard(
    database: str, names: str | Sequence[str], request: HazardRequest, report: Report = silent
) -> HazardRun:
    """Compute and store the runout of paths by one model, or by several averaged.

    One row for each path and each return period, with its design runout, or volume, sorted by path.
    Rows are stored as they come; the same call goes on where it was interrupted. Raises
    `AvahazardError` where there is no such model or path, `effect_files` are not the model's, a
    file of `source` cannot be read, no path has what a return period needs, or models stand on
    other records.
    """
    work, of_model = hazard_work(database, names, request)
    run, resumed = run_paths(database, work, report)
    beyond: list[Note] = []
    failed: dict[str, str] = {}
    where: dict[Note, dict[str, None]] = {}
    n_paths = n_rows = 0
    with reading(database) as session:
        for found in read_run(session, run):
            beyond += [Note.read(note) for note in found.notes]
            if found.failed is not None:
                failed[found.path_id] = found.failed
            n_paths += found.failed is None
            n_rows += len(found.documents)
            for note in (Note.read(n) for row in found.documents for n in row["notes"]):
                where.setdefault(note, {})[found.path_id] = None
    left_out = (Note("left_out", reason=why) for why in failed.values())
    notes = [*resumed, *of_model, *beyond, *left_out]
    notes += placed({n: paths for n, paths in where.items() if n not in of_model}, n_paths)
    return HazardRun(database, run, n_rows, tuple(notes), failed)


def hazard_work(
    database: str, names: str | Sequence[str], request: HazardRequest
) -> tuple[PathWork, tuple[Note, ...]]:
    """What is done on each path, and the notes on the models. Raises as `run_hazard`."""
    if not request.return_periods and not request.volumes:
        request = replace(request, return_periods=(DEFAULT_RETURN_PERIOD,))
    asked = tuple(dict.fromkeys([names] if isinstance(names, str) else names))
    if not asked:
        raise AvahazardError("No model is named.", "Name one, or several to be averaged.")
    loaded = [load_for_paths(database, name, request.effect_files) for name in asked]
    models, survey = [model for model, _ in loaded], loaded[0][1]
    weights, kind = [1.0], BOUNDS
    notes = dict.fromkeys(note for model in models for note in notes_of_fit(model))
    if any(model.ignores_volume for model in models):
        notes[Note("any_volume")] = None
    settings: dict[str, Any] = {
        "return_periods": list(request.return_periods),
        "volumes": list(request.volumes),
        "n_draws": request.draws,
        "seed": request.seed,
        "source": source_settings(request.source),
    }
    if len(models) > 1:
        weights, kind = model_weights(database, asked, request.effect_files), AVERAGE
        settings["weights"] = dict(zip(asked, weights, strict=True))
        told = ", ".join(f"{name} {weight:.2f}" for name, weight in settings["weights"].items())
        notes = {Note("weights", weights=told): None, **notes}
    frequencies = None
    if request.return_periods:
        frequencies = volume_frequencies(survey.volumes, request.seed, request.source)
    weighted = tuple(zip(models, weights, strict=True))
    answer = partial(hazard_of_path, weighted, frequencies, request, tuple(notes))
    others = next((found.others for _, found in loaded if found.others), ())
    survey = replace(survey, others=others)
    path_ids = survey.paths_to_run(request.paths)
    work = PathWork(kind, "Runout", answer, models[0].calibration, survey, path_ids, settings)
    return work, tuple(notes)


def model_weights(
    database: str, names: Sequence[str], effect_files: Sequence[Path] = ()
) -> list[float]:
    """Weights of models by stacking: how well their mixture predicts records that are left out.

    Raises `AvahazardError` where they stand on other records, or one has no density of them.
    """
    # Slow to load, and of no use to one model.
    from avahazard.criticism.scoring.loo import leave_one_out, stacking_weights  # noqa: PLC0415

    density, records = [], set()
    for name in names:
        model, _ = load_stored(database, name, effect_files)
        require_friction_scatter(model)
        require_unchanged(model)
        records.add((model.calibration.data_fingerprint, model.n_events))
        if len(records) > 1:
            raise AvahazardError(
                f"{name} was calibrated on other records than {names[0]}: left-out records cannot "
                "weigh them.",
                "Average models that were calibrated on the same paths and events.",
            )
        density.append(leave_one_out(model).by_event)
    weights: list[float] = stacking_weights(np.column_stack(density)).tolist()
    return weights


def hazard_of_path(
    models: Sequence[tuple[FittedModel, float]],
    frequencies: Frequencies | None,
    request: HazardRequest,
    notes: Sequence[Note],
    task: PathTask,
) -> tuple[list[results.HazardRow], tuple[Note, ...]]:
    """The rows of a path by models with their weights; `notes` go with each.

    Raises `AvahazardError` where it lacks what a return period needs.
    """
    path_id, needs_volume = task.path_id, not all(m.ignores_volume for m, _ in models)
    frequency: VolumeFrequency | None = None
    scenarios: list[Scenario] = []
    refused: list[AvahazardError] = []
    for period in request.return_periods:
        assert frequencies is not None
        try:
            frequency = frequency or frequencies.of(path_id)
            returned = return_volume(frequency, period)
            scenarios.append(Scenario(path_id, returned.volume_m3, period, returned, frequency))
        except AvahazardError as error:
            if needs_volume:
                refused.append(error)
            else:
                scenarios.append(Scenario(path_id, None, period))
    rate = None
    if frequency is not None and any(scenario.frequency for scenario in scenarios):
        rate = frequency.volumes()
    elif frequencies is not None and not needs_volume:
        rate = frequencies.rate_alone(path_id)
    scenarios += [Scenario(path_id, volume) for volume in request.volumes]
    if not scenarios:
        raise refused[0]
    at = [scenario.any_volume_m3 for scenario in scenarios]
    seed = request.seed
    each = [
        Weighted(m.name, weight, path_hazard(m, task.records, path_id, rate, at, seed=seed))
        for m, weight in models
    ]
    beyond: dict[float | None, list[Note]] = {}
    if needs_volume:
        asked = {s.volume_m3 for s in scenarios if s.volume_m3 is not None}
        model = next(m for m, _ in models if not m.ignores_volume)
        beyond = {v: extrapolation(model, path_id, v) for v in asked}
    rows = []
    for row in path_rows(each, scenarios, request.draws, seed):
        of_rate = frequencies.notes(path_id) if row.return_period_years and frequencies else ()
        noted = (*of_rate, *row.notes, *beyond.get(row.volume_m3, ()), *notes)
        rows.append(replace(row, notes=noted))
    return rows, tuple(Note("left_out", reason=error.message) for error in refused)


def source_settings(source: VolumeSource) -> dict[str, Any]:
    """Where volumes come from, files by what they hold."""
    settings = asdict(source)
    if source.table is not None:
        settings["table"] = hashlib.sha256(source.table.read_bytes()).hexdigest()
    return settings


RETURN_PERIODS = (10.0, 30.0, 100.0, 300.0)
CURVE = tuple(float(t) for t in np.geomspace(1.2, 1000.0, 60))


def volumes(database: str, request: VolumesRequest) -> results.Volumes:
    """The frequency of volumes of each path, all where none is named; nothing is stored.

    Raises `AvahazardError` where a path is unknown, no path has what is needed, a file of `source`
    cannot be read, or `plot` is not a picture's name.
    """
    paths: tuple[str, ...] = many(request.paths)
    wanted, plot = request.return_periods or RETURN_PERIODS, request.plot
    require_picture(plot)
    records = records_of(database)
    named = [find_path(records, path_id).path_id for path_id in paths]
    frequencies = volume_frequencies(known_volumes(records), request.seed, request.source)
    entries, notes, refusals, curves = [], [], [], []
    for path_id in named or sorted(p.path_id for p in records.paths):
        try:
            frequency = frequencies.of(path_id)
        except AvahazardError as error:
            if named:
                raise
            refusals.append(error)
            notes.append(f"left out: {error.message}")
            continue
        entries.append(_entry(frequency, frequencies, wanted))
        if not entries[-1].levels:
            try:
                return_volume(frequency, max(wanted))
            except AvahazardError as error:
                notes.append(str(error))
        curves.append(_levels(frequency, CURVE))
    if not entries:
        raise next(iter(refusals), no_profiles())
    if plot is not None:
        from avahazard.report.plots import draw_return_levels  # noqa: PLC0415

        draw_return_levels(plot, entries, curves)
    return results.Volumes(Rows(entries), tuple(notes))


def _entry(
    frequency: VolumeFrequency, frequencies: Frequencies, periods: Sequence[float]
) -> results.PathVolumes:
    record = frequency.record
    return results.PathVolumes(
        path_id=frequency.path_id,
        method=frequency.method,
        source=frequency.source,
        pooled=frequency.pooled,
        n_records=None if record is None else record.n_events,
        n_volumes=None if record is None else len(record.log_volumes),
        first_year=None if record is None else record.first_year,
        last_year=None if record is None else record.last_year,
        years_not_observed=None if record is None else len(record.gaps),
        events_per_year=None if record is None else record.events_per_year,
        levels=_levels(frequency, periods),
        maxima=_maxima(frequencies, frequency.path_id),
    )


def _levels(frequency: VolumeFrequency, periods: Sequence[float]) -> Rows[results.ReturnLevel]:
    """The return levels that there are: events may be rarer than a short period."""
    found = []
    for period in periods:
        with suppress(AvahazardError):
            found.append(return_volume(frequency, period))
    return Rows(found)


def _maxima(frequencies: Frequencies, path_id: str) -> Rows[results.YearlyMaximum]:
    """The yearly largest volumes and the return periods of their rank, (n + 1) / rank."""
    record = frequencies.region.records.get(path_id)
    if record is None:
        return Rows()
    largest = np.sort(np.exp(record.log_maxima))[::-1]
    return Rows(
        results.YearlyMaximum((record.n_years + 1) / rank, float(volume))
        for rank, volume in enumerate(largest, 1)
    )


class NoDragError(AvahazardError):
    """Zones by a model whose speeds nothing but friction limits."""


def zones(
    database: str, name: str, request: ZonesRequest, report: Report = silent
) -> results.Zones:
    """Find and store speed, pressure and zones along paths: an entry for each that has a rate.

    Raises `AvahazardError` where there is no such model, path or limits, its scatter is in metres,
    `plot` is not the name of a picture, or no path has a rate of avalanches; `NoDragError` where
    neither drag nor measured speeds limit its speeds, without `no_drag`.
    """
    require_picture(request.plot)
    work, of_all = zones_work(database, name, request)
    run, resumed = run_paths(database, work, report)
    with reading(database) as session:
        found = list(read_run(session, run))
    entries = [results.ZonedPath.from_dict(document) for one in found for document in one.documents]
    notes = [Note("left_out", reason=one.failed) for one in found if one.failed is not None]
    if request.plot is not None:
        title = f"Zones by {name}, limits '{work.settings['limits']['name']}'"
        drag = all(note.key != "no_drag" for note in of_all)
        from avahazard.report.html.content import path_view  # noqa: PLC0415 (slow)
        from avahazard.report.plots import draw_paths  # noqa: PLC0415 (slow)

        with reading(database) as session:
            records = load_records(session, [entry.path_id for entry in entries])
        views = [path_view(records, entry.path_id, zones=entry) for entry in entries]
        draw_paths(request.plot, title, views, drag=drag)
    of_paths = [note for entry in entries for note in entry.notes if note not in of_all]
    return results.Zones(Rows(entries), (*resumed, *notes, *of_paths, *of_all))


def knows_speeds(model: FittedModel) -> bool:
    """Whether the speeds of a model can be used: drag or measured speeds limit them."""
    return limits_speed(model) or TRACK_SCATTER_NAME in model.calibration.parameters


def zones_work(
    database: str, name: str, request: ZonesRequest
) -> tuple[PathWork, tuple[Note, ...]]:
    """What is done on each path, and the notes that go with all. Raises as `zones`."""
    wanted = load_limits(request.limits)
    model, survey = load_for_paths(database, name, request.effect_files)
    require_friction_scatter(model)
    path_ids = survey.paths_to_run(request.paths)
    if not (request.no_drag or knows_speeds(model)):
        raise NoDragError(
            f"Nothing but friction limits the speeds of {name}: it has no drag on all of the path, "
            "and no measured speeds. Speeds and pressures would be too high where a path is steep "
            "and long.",
            f"Add drag: avahazard add {shlex.quote(name)} {_remedies()} --as NEW, and use NEW for "
            "zones, even where its runouts are no better; or import measured speeds and calibrate "
            "again; or accept speeds that are too high: "
            f"avahazard zones {shlex.quote(name)} --no-drag.",
        )
    periods = tuple(sorted({*request.return_periods, *wanted.return_periods}))
    no_drag = () if limits_speed(model) else (Note("no_drag", model=name, effects=_remedies()),)
    with reading(database) as session:
        compared = latest_comparison(session, name)
    off = [row.bias_m_s for row in failing_speeds(compared)] if compared else []
    fails = [Note("speeds_fail", model=name, bias=max(off, key=abs))] if off else []
    notes = (*map(Note.ready, wanted.notes), *no_drag, *fails, *notes_of_fit(model))
    frequencies = volume_frequencies(survey.volumes, request.seed, request.source)
    answer = partial(zones_of_path, model, frequencies, wanted, periods, request, notes)
    settings = {
        "limits": wanted.model_dump(),
        "return_periods": periods,
        "density": request.density,
        "density_sd": request.density_sd,
        "seed": request.seed,
        "source": source_settings(request.source),
    }
    work = PathWork(ZONES, "Zones", answer, model.calibration, survey, path_ids, settings)
    return work, notes


def zones_of_path(
    model: FittedModel,
    frequencies: Frequencies,
    limits: ZoneSystem,
    periods: Sequence[float],
    request: ZonesRequest,
    notes: Sequence[Note],
    task: PathTask,
) -> tuple[list[results.ZonedPath], tuple[Note, ...]]:
    """The entry of a path, with `notes`. Raises `AvahazardError` where it has no rate."""
    volumes = frequencies.volumes(task.path_id, by_volume=not model.ignores_volume)
    path = path_hazard(model, task.records, task.path_id, volumes, seed=request.seed)
    far = {period for period in periods if frequencies.extrapolated(task.path_id, period)}
    density = results.Density(request.density, request.density_sd)
    entry = path_zones(path, limits, periods, density, far, request.seed)
    of_rate = [note.about(task.path_id) for note in frequencies.notes(task.path_id)]
    return [replace(entry, notes=(*of_rate, *entry.notes, *notes))], ()


def load_limits(limits: str) -> ZoneSystem:
    """The limits of a preset or of a TOML file. Raises `AvahazardError` where there are none."""
    if limits in PRESETS:
        return PRESETS[limits]
    file = Path(limits)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise AvahazardError(
            f"There are no limits '{limits}'.",
            f"Name {', '.join(PRESETS)}, or a TOML file of your own.",
        ) from error
    return read_limits(file.name, text)


def _remedies() -> str:
    """The effects that hold the speed."""
    return " or ".join(entry.key for entry in catalogue().values() if entry.limits_speed)
