"""Runout per path, for volumes and return periods, by a stored model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from avahazard.hazard.future_events import future_bounds
from avahazard.hazard.row import hazard_row
from avahazard.hazard.runout_bounds import RunoutBounds, Spread
from avahazard.hazard.volume_frequency import ReturnVolume, VolumeFrequency, return_volume
from avahazard.inference.seeds import generator
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import find_path, find_profile
from avahazard.store.results import BOUNDS, save_result
from avahazard.store.session import writing
from avahazard.workflow.frequencies import Frequencies, VolumeSource, volume_frequencies
from avahazard.workflow.future_events import forecast, ignores_volume
from avahazard.workflow.hazard_words import interval_words
from avahazard.workflow.stored.model import StoredFit, load_stored
from avahazard.workflow.stored.own_effects import own_effects
from avahazard.workflow.uncertainties import path_uncertainties

N_DRAWS = 20_000
DEFAULT_RETURN_PERIOD = 100.0
HELD_WORTH_A_NOTE, HELD_TOO_MANY = 0.05, 0.5
"""Shares of draws that do not start: from the first it is said, from the second no bounds are
given."""
UNKNOWN = Spread(None, None, None, None)


@dataclass(frozen=True, slots=True)
class Wanted:
    """A row to come: a path with its volume, or with a return period and the volume of that."""

    path_id: str
    volume_m3: float | None
    return_period: float | None = None
    returned: ReturnVolume | None = None
    frequency: VolumeFrequency | None = None


def hazard(
    database: str,
    name: str,
    *,
    return_periods: Sequence[float] = (),
    volumes: Sequence[float] = (),
    paths: Sequence[str] = (),
    source: VolumeSource | None = None,
    n_draws: int = N_DRAWS,
    seed: int = 0,
    effect_files: Sequence[FilePath] = (),
    report: Callable[[str, float, float], None] = lambda _what, _done, _total: None,
) -> tuple[list[dict[str, Any]], list[str]]:
    """Compute and store the runout, and return its rows with notes for people.

    One row (docs/results.md) for each path and each return period (years) or volume (m3),
    sorted by path; with neither given, a return period of 100 years. Paths are those named, or
    all with a profile; among the latter those without what a return period needs are left out
    with a note. `source` says where the frequency of volumes comes from.

    Raises:
        AvahazardError: there is no such model or path, `effect_files` are not those that the
            model was made with, a volume is not over 0 or a return period not over 1 year, a
            file of `source` cannot be read, or no path has what a return period needs.
    """
    _check(volumes, "volume", "m3", 0.0)
    _check(return_periods, "return period", "years", 1.0)
    if not return_periods and not volumes:
        return_periods = (DEFAULT_RETURN_PERIOD,)
    stored = load_stored(database, name, own_effects(database, name, effect_files))
    records = stored.records
    frequencies = volume_frequencies(records, seed, source) if return_periods else None
    wanted, notes = _wanted(stored, records, return_periods, volumes, paths, frequencies)
    report("Runout", 0.0, len(wanted))
    pairs = [(w.path_id, w.volume_m3) for w in wanted]
    ready, future_events = forecast(stored, pairs)
    rows: list[dict[str, Any]] = []
    for path_id in dict.fromkeys(w.path_id for w in wanted):
        mine = [k for k, w in enumerate(wanted) if w.path_id == path_id]
        apart = path_uncertainties(stored, path_id, [wanted[k] for k in mine], frequencies, seed)
        for k, more in zip(mine, apart, strict=True):
            row = wanted[k]
            keys = (seed, "hazard", path_id, repr(row.volume_m3), repr(row.return_period))
            bounds = future_bounds(ready, future_events[k], n_draws, generator(*keys))
            rows.append(_row(stored, row, bounds, more))
            report("Runout", float(len(rows)), len(wanted))
    with writing(database) as session:
        save_result(session, BOUNDS, name, rows)
    return rows, notes + _notes(stored, rows)


def _check(values: Sequence[float], what: str, unit: str, least: float) -> None:
    for value in values:
        if not (np.isfinite(value) and value > least):
            raise AvahazardError(
                f"The {what} is {value:g}.", f"It must be a number of {unit} over {least:g}."
            )


def _wanted(
    stored: StoredFit,
    records: Records,
    return_periods: Sequence[float],
    volumes: Sequence[float],
    paths: Sequence[str],
    frequencies: Frequencies | None,
) -> tuple[list[Wanted], list[str]]:
    """The rows to compute, and why paths that nobody named are left out."""
    for path_id in paths:
        find_profile(records, find_path(records, path_id))
    profiles = {profile.path_id for profile in records.profiles}
    named = sorted(set(paths) or {p.path_id for p in records.paths} & profiles)
    if not named:
        raise AvahazardError(
            "There are no paths with a profile.", "Import paths.csv and profiles.csv first."
        )
    rows, notes, refusals = [], [], []
    for path_id in named:
        for period in dict.fromkeys(return_periods):
            assert frequencies is not None
            try:
                frequency = frequencies.of(path_id)
                returned = return_volume(frequency, period)
                rows.append(Wanted(path_id, returned.volume_m3, period, returned, frequency))
            except AvahazardError as error:
                if ignores_volume(stored):
                    rows.append(Wanted(path_id, None, period))
                elif paths:
                    raise
                else:
                    refusals.append(error)
                    notes.append(f"left out: {error.message}")
        rows += [Wanted(path_id, volume) for volume in dict.fromkeys(volumes)]
    if not rows:
        raise refusals[0]
    return rows, notes


def _row(
    stored: StoredFit,
    wanted: Wanted,
    bounds: RunoutBounds,
    more: dict[str, Any],
) -> dict[str, Any]:
    notes = []
    held = bounds.p_not_released
    if held > HELD_WORTH_A_NOTE:
        notes.append(
            f"{wanted.path_id}: the block does not start in {held:.0%} of the draws, since the "
            "slope at its release is under the friction. Give the path a release_elevation_m "
            "on steeper ground."
        )
    if held > HELD_TOO_MANY:
        bounds = replace(bounds, x=UNKNOWN, elevation=UNKNOWN)
        more = {key: value for key, value in more.items() if key == "reach"}
    period = wanted.return_period
    row = hazard_row(
        wanted.path_id,
        wanted.volume_m3,
        bounds,
        interval_words(stored, wanted.path_id, return_period=period is not None),
        wanted.returned,
        wanted.frequency,
    )
    return {**row, **more, "return_period_years": period, "notes": notes}


def _notes(stored: StoredFit, rows: Sequence[dict[str, Any]]) -> list[str]:
    notes = [note for row in rows for note in row["notes"]]
    if stored.records_changed:
        notes.append(f"the records have changed since {stored.name} was calibrated.")
    if not stored.result["diagnostics"]["converged"]:
        notes.append(f"the chains of {stored.name} have not converged.")
    if ignores_volume(stored):
        notes.append("this model's runout is the same for every volume and return period.")
    impossible = sum(row["n_nonpositive_friction"] for row in rows)
    if impossible:
        drawn = sum(row["n_draws"] for row in rows)
        notes.append(
            f"{impossible} of {drawn} draws of friction were not over 0, as the normal "
            "distribution has it; they are left out. The lognormal one never does this."
        )
    far = sorted({row["path_id"] for row in rows if row.get("extrapolated")})
    if far:
        notes.append(
            f"the return period is over twice the observed years of {', '.join(far)}, or past "
            "the ends of the table: an extrapolation."
        )
    return notes
