"""Speed, pressure and zones along the paths, by a stored model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path as FilePath

import numpy as np

from avahazard.effects.catalogue import catalogue
from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.frequencies import Frequencies, VolumeSource, volume_frequencies
from avahazard.hazard.zones.entry import path_zones
from avahazard.hazard.zones.limits import PRESETS, Limits
from avahazard.hazard.zones.limits_file import read_limits
from avahazard.hazard.zones.pressure import DENSITY_KG_M3, DENSITY_SD_KG_M3
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import paths_to_run
from avahazard.records.plain import plain
from avahazard.report.picture import require_picture
from avahazard.results.base import Rows
from avahazard.results.zones import Density, ZonedPath, Zones
from avahazard.store.results import ZONES, save_result
from avahazard.store.session import writing
from avahazard.workflow.stored.model import StoredFit, load_stored
from avahazard.workflow.stored.notes import notes_of_fit
from avahazard.workflow.stored.own_effects import own_effects
from avahazard.workflow.stored.path_hazard import ignores_volume, stored_path_hazard


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
) -> Zones:
    """Find and store speed, pressure and zones along paths.

    One entry for each path named, or each that has a profile and a rate of avalanches, by path,
    at the return periods (years) given and those of the limits.
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
    stored = load_stored(database, name, own_effects(database, name, effect_files))
    if stored.model.sigma_m is not None:
        raise AvahazardError(
            f"The scatter of {name} is in metres of the stop: it says nothing of speeds.",
            "Calibrate with the method marginal or gibbs.",
        )
    frequencies = volume_frequencies(stored.records, seed, source)
    rates, notes = _rates(stored, frequencies, paths)
    periods = sorted({*return_periods, *wanted.return_periods})
    of_flow = Density(density, density_sd)
    report("Zones", 0.0, len(rates))
    entries, smooth = [], {}
    for path_id, rate in rates.items():
        path = stored_path_hazard(stored, path_id, rate, seed=seed)
        far = {period for period in periods if frequencies.extrapolated(path_id, period)}
        entries.append(path_zones(path, wanted, periods, of_flow, far, seed))
        smooth[path_id] = path.avalanches.site.smooth
        report("Zones", float(len(entries)), len(rates))
    with writing(database) as session:
        save_result(session, ZONES, name, plain(entries))
    if plot is not None:
        from avahazard.report.zones_figure import DrawnZones, draw_zones  # noqa: PLC0415 (slow)

        names = {path.path_id: path.name or path.path_id for path in stored.records.paths}
        drawn = [
            DrawnZones(names[key], smooth[key], e) for key, e in zip(smooth, entries, strict=True)
        ]
        draw_zones(plot, f"Zones by {name}, limits '{wanted.name}'", drawn)
    return Zones(Rows(entries), (*notes, *wanted.notes, *_notes(stored, entries)))


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


def _rates(
    stored: StoredFit, frequencies: Frequencies, paths: Sequence[str]
) -> tuple[dict[str, EventVolumes], list[str]]:
    """Rate and volumes by path, and why paths that nobody named are left out."""
    found, notes, refusals = {}, [], []
    for path_id in paths_to_run(stored.records, paths):
        rate = frequencies.rate_alone(path_id) if ignores_volume(stored) else None
        try:
            found[path_id] = rate or frequencies.of(path_id).volumes()
        except AvahazardError as error:
            if paths:
                raise
            refusals.append(error)
            notes.append(f"left out: {error.message}")
    if not found:
        raise refusals[0]
    return found, notes


def _notes(stored: StoredFit, entries: Sequence[ZonedPath]) -> list[str]:
    notes = [note for entry in entries for note in entry.notes]
    if not any(entry.limits_speed for entry in stored.definitions):
        mend = " or ".join(e.key for e in catalogue().values() if e.limits_speed)
        notes.append(
            f"{stored.name} has no drag: nothing but friction limits its speeds, so that they and "
            "the pressures are too high where the path is steep and long. Measured speeds, and "
            f"the effect {mend}, would mend it."
        )
    return [*notes, *notes_of_fit(stored)]
