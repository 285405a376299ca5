"""Speed, pressure and zones along the paths, by a stored model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from avahazard.hazard.event_volumes import EventVolumes, one_volume
from avahazard.hazard.volume_frequency import N_DRAWS
from avahazard.hazard.zones.entry import path_zones
from avahazard.hazard.zones.limits import PRESETS, Limits
from avahazard.hazard.zones.limits_file import read_limits
from avahazard.hazard.zones.pressure import (
    DENSITY_KG_M3,
    DENSITY_SD_KG_M3,
    draw_densities,
)
from avahazard.inference.seeds import generator
from avahazard.inference.study import build_study
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.report.picture import require_picture
from avahazard.store.session import writing
from avahazard.store.zones import save_zones
from avahazard.workflow.drawing_zones import draw_zone_entries
from avahazard.workflow.frequencies import Frequencies, VolumeSource, volume_frequencies
from avahazard.workflow.one_path import find_path, find_profile
from avahazard.workflow.own_effects import own_effects
from avahazard.workflow.prospects import ignores_volume, path_avalanches
from avahazard.workflow.stored_model import (
    StoredFit,
    load_stored,
    records_changed,
    training_records,
)

ANY_VOLUME_M3 = 1e4
"""Stands for the volume where it does not matter."""


def zones(
    database: str,
    name: str,
    *,
    return_periods: Sequence[float] = (),
    limits: str = "swiss",
    density: float = DENSITY_KG_M3,
    density_sd: float = DENSITY_SD_KG_M3,
    paths: Sequence[str] = (),
    source: VolumeSource | None = None,
    seed: int = 0,
    plot: FilePath | None = None,
    effect_files: Sequence[FilePath] = (),
    report: Callable[[str, float, float], None] = lambda _what, _done, _total: None,
) -> tuple[list[dict[str, Any]], list[str]]:
    """Find and store speed, pressure and zones, and return them with notes for people.

    An entry for each path named, or each that has a profile and a rate of avalanches, by path:
    `path_id`, `limits` (name), `density_kg_m3` (`mean`, `sd`), `release_x_m`, `end_x_m` (of the
    profile), `interval` (what the quantiles are of), `places`, `zones` and `notes`. Each of
    `places`, from the highest release to the end, has `x_m`, `elevation_m`, `p_reach_per_year`
    (median chance that a year's avalanches pass it) and `by_return_period`: for those given and
    those of the limits the speed (m/s) and pressure ρu² (kPa) that a year exceeds with chance
    1/T, at 5, 50 and 95 % of the posterior. Each of `zones`, the worst first: `zone`, `color`,
    `from_x_m`, `to_x_m`, `to_x_q05_m`, `to_x_q95_m` (None: beyond) and `beyond` (`ZonePiece`).
    `limits` is the name of a preset or of a TOML file; with `plot` a picture is written there.

    Raises:
        AvahazardError: there is no such model, path or preset, the file of limits cannot be
            used, `effect_files` are not those of the model, its scatter is in metres (method
            metropolis), a density or return period is out of range, `plot` is not the name of a
            picture, or no path has a rate.
    """
    if plot is not None:
        require_picture(plot)
    _check(density, density_sd, return_periods)
    wanted = load_limits(limits)
    stored, records = load_stored(database, name, own_effects(database, name, effect_files))
    if stored.method == "metropolis":
        raise AvahazardError(
            f"The scatter of {name} is in metres of the stop: it says nothing of speeds.",
            "Calibrate with the method marginal or gibbs.",
        )
    frequencies = volume_frequencies(records, seed, source)
    volumes, notes = _volumes(stored, records, frequencies, paths)
    periods = sorted({*return_periods, *wanted.return_periods})
    prior = build_study(training_records(stored, records))
    report("Zones", 0.0, len(volumes))
    entries = []
    for path_id, of_path in volumes.items():
        ready = path_avalanches(stored, records, path_id, of_path, seed, prior)
        densities = draw_densities(
            density, density_sd, ready.n_parameters, generator(seed, "density", path_id)
        )
        entry = {
            "path_id": path_id,
            "limits": wanted.name,
            "density_kg_m3": {"mean": density, "sd": density_sd},
            **path_zones(ready, wanted, periods, densities),
            "notes": _extrapolated(frequencies, path_id, periods),
        }
        entries.append(entry)
        report("Zones", float(len(entries)), len(volumes))
    with writing(database) as session:
        save_zones(session, name, entries)
    if plot is not None:
        draw_zone_entries(plot, f"Zones by {name}, limits '{wanted.name}'", records, entries)
    return entries, [*notes, *wanted.notes, *_notes(stored, records, entries)]


def load_limits(limits: str) -> Limits:
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


def _check(density: float, density_sd: float, return_periods: Sequence[float]) -> None:
    if not (np.isfinite(density) and density > 0.0):
        raise AvahazardError(f"The density is {density:g}.", "It must be in kg/m3, over 0.")
    if not (np.isfinite(density_sd) and density_sd >= 0.0):
        raise AvahazardError(
            f"The standard deviation of the density is {density_sd:g}.",
            "It must be in kg/m3, 0 or more.",
        )
    for period in return_periods:
        if not (np.isfinite(period) and period > 1.0):
            raise AvahazardError(
                f"The return period is {period:g}.", "It must be a number of years over 1."
            )


def _volumes(
    stored: StoredFit, records: Records, frequencies: Frequencies, paths: Sequence[str]
) -> tuple[dict[str, EventVolumes], list[str]]:
    """Rate and volumes by path, and why paths that nobody named are left out."""
    for path_id in paths:
        find_profile(records, find_path(records, path_id))
    profiles = {profile.path_id for profile in records.profiles}
    named = sorted(set(paths) or {p.path_id for p in records.paths} & profiles)
    if not named:
        raise AvahazardError(
            "There are no paths with a profile.", "Import paths.csv and profiles.csv first."
        )
    found, notes, refusals = {}, [], []
    for path_id in named:
        try:
            found[path_id] = _of_path(stored, frequencies, path_id)
        except AvahazardError as error:
            if paths:
                raise
            refusals.append(error)
            notes.append(f"left out: {error.message}")
    if not found:
        raise refusals[0]
    return found, notes


def _of_path(stored: StoredFit, frequencies: Frequencies, path_id: str) -> EventVolumes:
    rate = frequencies.rate_of(path_id, N_DRAWS) if ignores_volume(stored) else None
    if rate is None:
        return frequencies.of(path_id).volumes()
    any_volume = one_volume(ANY_VOLUME_M3, N_DRAWS)
    return EventVolumes(rate, any_volume.log_volume, any_volume.share)


def _extrapolated(frequencies: Frequencies, path_id: str, periods: Sequence[float]) -> list[str]:
    try:
        frequency = frequencies.of(path_id)
    except AvahazardError:
        return []
    far = [f"{period:g}" for period in periods if frequency.extrapolated(period)]
    if not far:
        return []
    return [f"{path_id}: the record is too short for T = {', '.join(far)}: an extrapolation."]


def _notes(stored: StoredFit, records: Records, entries: Sequence[dict[str, Any]]) -> list[str]:
    notes = [note for entry in entries for note in entry["notes"]]
    if "turbulent-drag" not in stored.specification.effects and not stored.own:
        notes.append(
            f"{stored.name} has no drag: nothing but friction limits its speeds, so that they and "
            "the pressures are too high where the path is steep and long. Measured speeds, and "
            "the effect turbulent-drag, would mend it."
        )
    if records_changed(stored, records):
        notes.append(f"the records have changed since {stored.name} was calibrated.")
    if not stored.result["diagnostics"]["converged"]:
        notes.append(f"the chains of {stored.name} have not converged.")
    return notes
