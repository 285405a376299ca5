"""Speed, pressure and zones along the paths, by a stored model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath

from avahazard.effects.catalogue import catalogue
from avahazard.hazard.frequency import Frequencies, volume_frequencies
from avahazard.hazard.path_hazard import path_hazard
from avahazard.hazard.zones import PRESETS, ZoneSystem, path_zones, read_limits
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.model.layout import TRACK_SCATTER_NAME
from avahazard.notes import Note
from avahazard.records.errors import AvahazardError
from avahazard.report.picture import require_picture
from avahazard.results.base import Report, Rows, plain, silent
from avahazard.results.hazard import Density, ZonedPath, Zones
from avahazard.store.records import load_records
from avahazard.store.results import ZONES, read_run
from avahazard.store.session import reading
from avahazard.workflow.by_path import PathTask, PathWork, run_paths
from avahazard.workflow.hazard import source_settings
from avahazard.workflow.requests import ZonesRequest
from avahazard.workflow.stored import (
    limits_speed,
    load_for_paths,
    notes_of_fit,
    require_friction_scatter,
)


class NoDragError(AvahazardError):
    """Zones by a model whose speeds nothing but friction limits."""


def zones(database: str, name: str, request: ZonesRequest, report: Report = silent) -> Zones:
    """Find and store speed, pressure and zones along paths: an entry for each that has a rate.

    Raises `AvahazardError` where there is no such model, path or preset, the file of limits cannot
    be used, `effect_files` are not those of the model, its scatter is in metres, `plot` is not the
    name of a picture, or no path has a rate of avalanches; `NoDragError` where neither drag nor
    measured speeds limit its speeds, without `no_drag`.
    """
    require_picture(request.plot)
    work, of_all = zones_work(database, name, request)
    run, resumed = run_paths(database, work, report)
    with reading(database) as session:
        found = list(read_run(session, run))
    entries = [ZonedPath.from_dict(document) for one in found for document in one.documents]
    notes = [Note("left_out", reason=one.failed) for one in found if one.failed is not None]
    if request.plot is not None:
        title = f"Zones by {name}, limits '{work.settings['limits']['name']}'"
        drag = all(note.key != "no_drag" for note in of_all)
        _draw(request.plot, database, entries, title, drag=drag)
    of_paths = [note for entry in entries for note in entry.notes if note not in of_all]
    return Zones(Rows(entries), (*resumed, *notes, *of_paths, *of_all))


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
    if not (request.no_drag or knows_speeds(model)):
        raise NoDragError(
            f"Nothing but friction limits the speeds of {name}: it has no drag on all of the path, "
            "and no measured speeds. Speeds and pressures would be too high where a path is steep "
            "and long.",
            f"Add drag: avahazard add {name} {_remedies()} --as NEW; or import measured speeds and "
            f"calibrate again; or accept it: avahazard zones {name} --no-drag.",
        )
    seed, source = request.seed, request.source
    periods = tuple(sorted({*request.return_periods, *wanted.return_periods}))
    no_drag = () if limits_speed(model) else (Note("no_drag", model=name, effects=_remedies()),)
    notes = (*map(Note.ready, wanted.notes), *no_drag, *notes_of_fit(model))
    answer = partial(
        zones_of_path,
        model,
        volume_frequencies(survey.volumes, seed, source),
        wanted,
        periods,
        Density(request.density, request.density_sd),
        notes,
        seed=seed,
    )
    settings = {
        "limits": plain(wanted),
        "return_periods": periods,
        "density": request.density,
        "density_sd": request.density_sd,
        "seed": seed,
        "source": source_settings(source),
    }
    path_ids = survey.paths_to_run(request.paths)
    work = PathWork(ZONES, "Zones", answer, model.calibration, survey, path_ids, settings)
    return work, notes


def zones_of_path(
    model: FittedModel,
    frequencies: Frequencies,
    limits: ZoneSystem,
    periods: Sequence[float],
    density: Density,
    notes: Sequence[Note],
    task: PathTask,
    *,
    seed: int,
) -> tuple[list[ZonedPath], tuple[Note, ...]]:
    """The entry of a path, with `notes`. Raises `AvahazardError` where it has no rate."""
    volumes = frequencies.volumes(task.path_id, by_volume=not model.ignores_volume)
    path = path_hazard(model, task.records, task.path_id, volumes, seed=seed)
    far = {period for period in periods if frequencies.extrapolated(task.path_id, period)}
    entry = path_zones(path, limits, periods, density, far, seed)
    of_rate = [note.about(task.path_id) for note in frequencies.notes(task.path_id)]
    return [replace(entry, notes=(*of_rate, *entry.notes, *notes))], ()


def _draw(
    plot: FilePath, database: str, entries: Sequence[ZonedPath], title: str, *, drag: bool
) -> None:
    from avahazard.report.html.content import path_view  # noqa: PLC0415 (slow)
    from avahazard.report.path_pictures import draw_paths  # noqa: PLC0415 (slow)

    with reading(database) as session:
        records = load_records(session, [entry.path_id for entry in entries])
    views = [path_view(records, of.path_id, zones=of) for of in entries]
    draw_paths(plot, title, views, drag=drag)


def load_limits(limits: str) -> ZoneSystem:
    """The limits of a preset or of a TOML file. Raises `AvahazardError` where there are none."""
    if limits in PRESETS:
        return PRESETS[limits]
    file = FilePath(limits)
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
