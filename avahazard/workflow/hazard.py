"""Runout bounds per path, for volumes and return periods, by a stored model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from avahazard.hazard.prospect import prospect_bounds
from avahazard.hazard.row import hazard_row
from avahazard.hazard.runout_bounds import RunoutBounds, Spread
from avahazard.hazard.volume_frequency import (
    ReturnVolume,
    VolumeFrequency,
    fit_volume_frequency,
    return_volume,
)
from avahazard.hazard.volume_record import VolumeRecord, volume_record
from avahazard.inference.seeds import generator
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.store.hazard import save_hazard
from avahazard.store.session import writing
from avahazard.workflow.one_path import find_path, find_profile
from avahazard.workflow.own_effects import own_effects
from avahazard.workflow.prospects import forecast, ignores_volume, takes_event_columns
from avahazard.workflow.stored_model import StoredFit, load_stored, records_changed

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
    n_draws: int = N_DRAWS,
    seed: int = 0,
    effect_files: Sequence[FilePath] = (),
    report: Callable[[str, float, float], None] = lambda _what, _done, _total: None,
) -> tuple[list[dict[str, Any]], list[str]]:
    """Compute and store the bounds of the runout, and return them with notes for people.

    One row (contract, `hazard`) for each path and each return period (years) or volume (m3),
    sorted by path; with neither given, a return period of 100 years. Paths are those named, or
    all with a profile; among the latter those without what a return period needs are left out
    with a note. Besides the contract's keys a row has `notes` and, for a return period, where
    its volume comes from.

    Raises:
        AvahazardError: there is no such model or path, `effect_files` are not those that the
            model was made with, a volume or return period is not over 0, or no path has what
            a return period needs.
    """
    _check(return_periods, "return period", "years")
    _check(volumes, "volume", "m3")
    if not return_periods and not volumes:
        return_periods = (DEFAULT_RETURN_PERIOD,)
    stored, records = load_stored(database, name, own_effects(database, name, effect_files))
    wanted, notes = _wanted(stored, records, return_periods, volumes, paths, seed)
    report("Bounds of the runout", 0.0, len(wanted))
    ready, prospects = forecast(stored, records, [(w.path_id, w.volume_m3) for w in wanted])
    rows = []
    for k, (row, prospect) in enumerate(zip(wanted, prospects, strict=True)):
        rng = generator(seed, "hazard", row.path_id, repr(row.volume_m3), repr(row.return_period))
        bounds = prospect_bounds(ready, prospect, n_draws, rng)
        rows.append(_row(stored, row, bounds))
        report("Bounds of the runout", k + 1.0, len(wanted))
    with writing(database) as session:
        save_hazard(session, name, rows)
    return rows, notes + _notes(stored, records, rows)


def interval_words(stored: StoredFit, path_id: str, *, return_period: bool) -> str:
    """What varies within the 5 to 95 % of a row, in words."""
    parts = []
    if stored.method == "metropolis":
        parts.append("scatter of the stop by sigma metres of elevation")
    else:
        tails = " (Student's t)" if stored.specification.tails == "student" else ""
        parts.append(
            f"natural scatter of friction ({stored.specification.distribution}{tails}) "
            "between avalanches"
        )
    parts.append("uncertainty of the calibrated parameters")
    if "path-effect" in stored.specification.effects and path_id not in stored.offsets:
        parts.append("the unknown friction of a path without records")
    if takes_event_columns(stored):
        parts.append("columns of the event, as in the records")
    text = "90 % of avalanches; varying: " + ", ".join(parts)
    if ignores_volume(stored):
        return f"{text}; the volume does not matter to this model"
    if return_period:
        return f"{text}; fixed: the volume of the return period (its own error apart)"
    return f"{text}; fixed: the volume"


def _check(values: Sequence[float], what: str, unit: str) -> None:
    for value in values:
        if not (np.isfinite(value) and value > 0.0):
            raise AvahazardError(
                f"The {what} is {value:g}.", f"It must be a number of {unit} over 0."
            )


def _wanted(
    stored: StoredFit,
    records: Records,
    return_periods: Sequence[float],
    volumes: Sequence[float],
    paths: Sequence[str],
    seed: int,
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
    volume_records = _volume_records(records) if return_periods else {}
    rows, notes, refusals = [], [], []
    for path_id in named:
        for period in dict.fromkeys(return_periods):
            try:
                rows.append(_return_row(path_id, period, volume_records, seed))
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


def _volume_records(records: Records) -> dict[str, VolumeRecord | AvahazardError]:
    """The volume record of each path, or why it has none."""
    by_path: dict[str, list[Event]] = {path.path_id: [] for path in records.paths}
    for event in records.events:
        if event.path_id is not None:
            by_path[event.path_id].append(event)
    found: dict[str, VolumeRecord | AvahazardError] = {}
    for path in records.paths:
        try:
            found[path.path_id] = volume_record(path, by_path[path.path_id])
        except AvahazardError as error:
            found[path.path_id] = error
    return found


def _return_row(
    path_id: str, period: float, found: dict[str, VolumeRecord | AvahazardError], seed: int
) -> Wanted:
    own = found[path_id]
    if isinstance(own, AvahazardError):
        raise own
    known = [record for record in found.values() if isinstance(record, VolumeRecord)]
    frequency = fit_volume_frequency(path_id, known)
    rng = generator(seed, "return volume", path_id, repr(period))
    returned = return_volume(frequency, period, rng)
    return Wanted(path_id, returned.volume_m3, period, returned, frequency)


def _row(stored: StoredFit, wanted: Wanted, bounds: RunoutBounds) -> dict[str, Any]:
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
    period = wanted.return_period
    interval = interval_words(stored, wanted.path_id, return_period=period is not None)
    row = hazard_row(
        wanted.path_id,
        wanted.volume_m3,
        bounds,
        interval,
        wanted.returned,
        wanted.frequency,
    )
    return {**row, "return_period_years": period, "notes": notes}


def _notes(stored: StoredFit, records: Records, rows: Sequence[dict[str, Any]]) -> list[str]:
    notes = [note for row in rows for note in row["notes"]]
    if records_changed(stored, records):
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
            f"the return period is over twice the observed years of {', '.join(far)}: "
            "an extrapolation."
        )
    return notes
