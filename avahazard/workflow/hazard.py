"""Design runouts and runouts of volumes per path, by a stored model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np

from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.frequencies import Frequencies, VolumeSource, volume_frequencies
from avahazard.hazard.path_rows import path_rows
from avahazard.hazard.scenario import Scenario
from avahazard.hazard.volume_frequency import return_volume
from avahazard.inference.prediction.extrapolation import extrapolation
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import paths_to_run
from avahazard.records.plain import plain
from avahazard.results.base import Rows
from avahazard.results.hazard import Hazard, HazardRow
from avahazard.store.results import BOUNDS, save_result
from avahazard.store.session import writing
from avahazard.workflow.stored.model import StoredFit, load_stored
from avahazard.workflow.stored.notes import notes_of_fit
from avahazard.workflow.stored.own_effects import own_effects
from avahazard.workflow.stored.path_hazard import ignores_volume, stored_path_hazard

N_DRAWS = 20_000
DEFAULT_RETURN_PERIOD = 100.0


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
) -> Hazard:
    """Compute and store the runout of paths.

    One row for each path and each return period (years), with its design runout, or volume (m3),
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
    frequencies = volume_frequencies(stored.records, seed, source) if return_periods else None
    scenarios, notes = _scenarios(stored, return_periods, volumes, paths, frequencies)
    n_rows = sum(len(of_path) for of_path in scenarios.values())
    report("Runout", 0.0, n_rows)
    rows: list[HazardRow] = []
    of_model = _model_notes(stored)
    for path_id, of_path in scenarios.items():
        rate = _volumes(stored, of_path, frequencies)
        at = [scenario.any_volume_m3 for scenario in of_path]
        path = stored_path_hazard(stored, path_id, rate, at, seed=seed)
        mine = path_rows(path, of_path, n_draws, seed)
        rows += [replace(row, notes=(*row.notes, *of_model)) for row in mine]
        report("Runout", float(len(rows)), n_rows)
    with writing(database) as session:
        save_result(session, BOUNDS, name, plain(rows))
    beyond = _extrapolated(stored, rows)
    return Hazard(Rows(rows), (*of_model, *beyond, *notes, *_in_short(rows, of_model)))


def _check(values: Sequence[float], what: str, unit: str, least: float) -> None:
    for value in values:
        if not (np.isfinite(value) and value > least):
            raise AvahazardError(
                f"The {what} is {value:g}.", f"It must be a number of {unit} over {least:g}."
            )


def _scenarios(
    stored: StoredFit,
    return_periods: Sequence[float],
    volumes: Sequence[float],
    paths: Sequence[str],
    frequencies: Frequencies | None,
) -> tuple[dict[str, list[Scenario]], list[str]]:
    """The rows to compute by path, and why paths that nobody named are left out."""
    found: dict[str, list[Scenario]] = {}
    notes, refusals = [], []
    for path_id in paths_to_run(stored.records, paths):
        mine = []
        for period in dict.fromkeys(return_periods):
            assert frequencies is not None
            try:
                frequency = frequencies.of(path_id)
                returned = return_volume(frequency, period)
                mine.append(Scenario(path_id, returned.volume_m3, period, returned, frequency))
            except AvahazardError as error:
                if ignores_volume(stored):
                    mine.append(Scenario(path_id, None, period))
                elif paths:
                    raise
                else:
                    refusals.append(error)
                    notes.append(f"left out: {error.message}")
        mine += [Scenario(path_id, volume) for volume in dict.fromkeys(volumes)]
        if mine:
            found[path_id] = mine
    if not found:
        raise refusals[0]
    return found, notes


def _volumes(
    stored: StoredFit, scenarios: Sequence[Scenario], frequencies: Frequencies | None
) -> EventVolumes | None:
    """Rate and volumes of a path; None where nothing is known, or no return period is asked."""
    for scenario in scenarios:
        if scenario.frequency is not None:
            return scenario.frequency.volumes()
    if frequencies is None or not ignores_volume(stored):
        return None
    return frequencies.rate_alone(scenarios[0].path_id)


def _extrapolated(stored: StoredFit, rows: Sequence[HazardRow]) -> list[str]:
    """What volumes of the rows lie beyond the records, and where friction goes there."""
    if ignores_volume(stored):
        return []
    asked = dict.fromkeys((row.path_id, row.volume_m3) for row in rows)
    return [
        note
        for path_id, volume in asked
        if volume is not None
        for note in extrapolation(stored.model, path_id, volume).notes()
    ]


def _model_notes(stored: StoredFit) -> list[str]:
    """What goes with every row of a model."""
    notes = list(notes_of_fit(stored))
    if ignores_volume(stored):
        notes.append("this model's friction is the same for every volume.")
    return notes


def _in_short(rows: Sequence[HazardRow], of_model: Sequence[str]) -> list[str]:
    """The notes of single rows, each once, with the paths that it is on where not on all."""
    paths = list(dict.fromkeys(row.path_id for row in rows))
    where: dict[str, list[str]] = {}
    for row in rows:
        for note in (note for note in row.notes if note not in of_model):
            mine = where.setdefault(note, [])
            if row.path_id not in mine:
                mine.append(row.path_id)
    return [
        note if len(mine) == len(paths) > 1 else f"{', '.join(mine)}: {note}"
        for note, mine in where.items()
    ]
