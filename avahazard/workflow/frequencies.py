"""Frequency of volumes per path, from whatever source the user has."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.volume_frequency import (
    Family,
    Region,
    VolumeFrequency,
    fit_volume_frequency,
    region_of,
)
from avahazard.hazard.volume_record import VolumeRecord, volume_record
from avahazard.inference.seeds import generator
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class VolumeSource:
    """Where the frequency of volumes comes from.

    `family` is `gev` of yearly maxima or `gpd` over a threshold (m3; without one, the median of
    each path's volumes).
    """

    family: Family = "gev"
    threshold_m3: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Frequencies:
    """Frequencies of volumes by path, fitted when they are asked for; `refused` says why not."""

    region: Region
    refused: dict[str, AvahazardError]
    seed: int
    fitted: dict[str, VolumeFrequency] = field(default_factory=dict)

    def of(self, path_id: str) -> VolumeFrequency:
        """The frequency of a path. Raises `AvahazardError` where there is none."""
        if path_id in self.refused:
            raise self.refused[path_id]
        if path_id not in self.fitted:
            rng = generator(self.seed, "frequency", path_id)
            self.fitted[path_id] = fit_volume_frequency(self.region, path_id, rng)
        return self.fitted[path_id]

    def rate_of(self, path_id: str, n: int) -> Floats | None:
        """Draws `[n]` of the rate of avalanches of a path, None where its record has none."""
        record = self.region.records.get(path_id)
        if record is None:
            return None
        rng = generator(self.seed, "rate", path_id)
        return np.asarray(rng.gamma(record.n_events + 0.5, 1.0 / record.n_years, n))


def volume_frequencies(
    records: Records, seed: int, source: VolumeSource | None = None
) -> Frequencies:
    """The frequencies of all paths of the records. Raises `AvahazardError` for a bad source."""
    source = source or VolumeSource()
    known, refused = volume_records(records)
    return Frequencies(region_of(known, source.family, source.threshold_m3), refused, seed)


def volume_records(records: Records) -> tuple[list[VolumeRecord], dict[str, AvahazardError]]:
    """The volume record of each path, or why it has none."""
    by_path: dict[str, list[Event]] = {path.path_id: [] for path in records.paths}
    for event in records.events:
        if event.path_id is not None:
            by_path[event.path_id].append(event)
    known: list[VolumeRecord] = []
    refused: dict[str, AvahazardError] = {}
    for path in records.paths:
        try:
            known.append(volume_record(path, by_path[path.path_id]))
        except AvahazardError as error:
            refused[path.path_id] = error
    return known, refused
