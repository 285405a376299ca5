"""The runouts of one path: the unit of work of `hazard`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.frequencies import Frequencies
from avahazard.hazard.path_rows import path_rows
from avahazard.hazard.scenario import Scenario
from avahazard.hazard.volume_frequency import return_volume
from avahazard.inference.prediction.extrapolation import extrapolation
from avahazard.records.errors import AvahazardError
from avahazard.workflow.hazard_notes import model_notes
from avahazard.workflow.stored.path_hazard import AppliedModel, applied_model
from avahazard.workflow.stored.path_unit import PathAnswer, PathTask
from avahazard.workflow.stored.region_fit import RegionFit


@dataclass(frozen=True, slots=True, eq=False)
class HazardUnit:
    """What the runouts of every path take: the model, and what is asked (years, m3)."""

    model: AppliedModel
    notes: tuple[str, ...]
    frequencies: Frequencies | None
    return_periods: tuple[float, ...]
    volumes: tuple[float, ...]
    n_draws: int
    seed: int

    @classmethod
    def of(
        cls,
        stored: RegionFit,
        frequencies: Frequencies | None,
        return_periods: tuple[float, ...],
        volumes: tuple[float, ...],
        n_draws: int,
        seed: int,
    ) -> HazardUnit:
        """Of a stored model."""
        notes = tuple(model_notes(stored))
        model = applied_model(stored)
        return cls(model, notes, frequencies, return_periods, volumes, n_draws, seed)


def hazard_of_path(unit: HazardUnit, task: PathTask) -> PathAnswer:
    """The rows of a path. Raises `AvahazardError` where it lacks what a return period needs."""
    frequencies = unit.frequencies
    if frequencies is not None:
        # Fits of other paths are not kept.
        frequencies = replace(frequencies, fitted={})
    scenarios, notes = _scenarios(unit, task.path_id, frequencies)
    rate = _volumes(unit, scenarios, frequencies)
    at = [scenario.any_volume_m3 for scenario in scenarios]
    path = unit.model.path(task.records, task.path_id, rate, at, seed=unit.seed)
    rows = path_rows(path, scenarios, unit.n_draws, unit.seed)
    asked = {s.volume_m3 for s in scenarios if s.volume_m3 is not None}
    beyond: dict[float | None, list[str]] = {}
    if unit.model.volume_matters:
        fitted = unit.model.fitted
        beyond = {v: extrapolation(fitted, task.path_id, v).sentences() for v in asked}
    told = [
        replace(row, notes=(*row.notes, *beyond.get(row.volume_m3, ()), *unit.notes))
        for row in rows
    ]
    return PathAnswer(told, tuple(notes))


def _scenarios(
    unit: HazardUnit, path_id: str, frequencies: Frequencies | None
) -> tuple[list[Scenario], list[str]]:
    """The rows to compute, and why return periods are left out beside others or volumes."""
    found: list[Scenario] = []
    refused: list[AvahazardError] = []
    for period in unit.return_periods:
        assert frequencies is not None
        try:
            frequency = frequencies.of(path_id)
            returned = return_volume(frequency, period)
            found.append(Scenario(path_id, returned.volume_m3, period, returned, frequency))
        except AvahazardError as error:
            if unit.model.volume_matters:
                refused.append(error)
            else:
                found.append(Scenario(path_id, None, period))
    found += [Scenario(path_id, volume) for volume in unit.volumes]
    if not found:
        raise refused[0]
    return found, [f"left out: {error.message}" for error in refused]


def _volumes(
    unit: HazardUnit, scenarios: Sequence[Scenario], frequencies: Frequencies | None
) -> EventVolumes | None:
    """Rate and volumes of a path; None where nothing is known, or no return period is asked."""
    for scenario in scenarios:
        if scenario.frequency is not None:
            return scenario.frequency.volumes()
    if frequencies is None or unit.model.volume_matters:
        return None
    return frequencies.rate_alone(scenarios[0].path_id)
