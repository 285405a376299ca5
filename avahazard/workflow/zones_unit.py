"""The zones of one path: the unit of work of `zones`."""

from __future__ import annotations

from dataclasses import dataclass, replace

from avahazard.hazard.frequencies import Frequencies
from avahazard.hazard.zones.entry import path_zones
from avahazard.hazard.zones.limits import Limits
from avahazard.results.zones import Density
from avahazard.workflow.stored.path_hazard import AppliedModel
from avahazard.workflow.stored.path_unit import PathAnswer, PathTask


@dataclass(frozen=True, slots=True, eq=False)
class ZonesUnit:
    """What the zones of every path take: the model, and what is asked (`path_zones`).

    `notes` go with all of them.
    """

    model: AppliedModel
    notes: tuple[str, ...]
    frequencies: Frequencies
    limits: Limits
    periods: tuple[float, ...]
    density: Density
    seed: int


def zones_of_path(unit: ZonesUnit, task: PathTask) -> PathAnswer:
    """The entry of a path. Raises `AvahazardError` where it has no rate of avalanches."""
    # Fits of other paths are not kept.
    frequencies = replace(unit.frequencies, fitted={})
    rate = None if unit.model.volume_matters else frequencies.rate_alone(task.path_id)
    volumes = rate or frequencies.of(task.path_id).volumes()
    path = unit.model.path(task.records, task.path_id, volumes, seed=unit.seed)
    far = {period for period in unit.periods if frequencies.extrapolated(task.path_id, period)}
    entry = path_zones(path, unit.limits, unit.periods, unit.density, far, unit.seed)
    return PathAnswer([replace(entry, notes=(*entry.notes, *unit.notes))])
