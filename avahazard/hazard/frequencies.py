"""Frequency of volumes per path, from whatever source the user has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.event_volumes import ANY_VOLUME_M3, EventVolumes, one_volume
from avahazard.hazard.snowfall import snowfall_frequency
from avahazard.hazard.volume_frequency import N_DRAWS, VolumeFrequency, fit_volume_frequency
from avahazard.hazard.volume_record import VolumeRecord, volume_record
from avahazard.hazard.volume_region import Region, region_of
from avahazard.hazard.volume_source import VolumeSource
from avahazard.hazard.volume_table import table_frequency
from avahazard.inference.seeds import generator
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.frequency_files import read_return_volumes, read_snow_depths
from avahazard.records.lookup import of_path
from avahazard.records.path import Path

RELEASE_AREA = "release_area_m2"
"""The column of paths that snowfall is made a volume by."""


@dataclass(frozen=True, slots=True)
class KnownVolumes:
    """What the records of paths tell of their volumes, gathered piece by piece.

    `refused` says of a path why it has no record; `areas` are release areas (m2) of paths that
    state one over 0.
    """

    records: list[VolumeRecord] = field(default_factory=list)
    refused: dict[str, AvahazardError] = field(default_factory=dict)
    areas: dict[str, float] = field(default_factory=dict)

    def add(self, path: Path, events: Sequence[Event]) -> None:
        """Add a path, given all its events."""
        try:
            self.records.append(volume_record(path, events))
        except AvahazardError as error:
            # Its traceback would hold the events.
            self.refused[path.path_id] = error.with_traceback(None)
        area = path.covariates.get(RELEASE_AREA)
        if isinstance(area, float | int) and area > 0.0:
            self.areas[path.path_id] = float(area)


def known_volumes(records: Records) -> KnownVolumes:
    """What whole records tell of the volumes of their paths."""
    known = KnownVolumes()
    for path in records.paths:
        known.add(path, of_path(records, path.path_id).events)
    return known


@dataclass(frozen=True, slots=True, eq=False)
class Frequencies:
    """Frequencies of volumes by path, fitted when they are asked for; `refused` says why not.

    `table` and `depths` are what the files of `source` hold, None without them; `areas` (m2) the
    release areas of paths that have one.
    """

    region: Region
    refused: dict[str, AvahazardError]
    seed: int
    source: VolumeSource
    table: dict[str, list[tuple[float, float]]] | None
    depths: dict[str | None, Floats] | None
    areas: dict[str, float]
    fitted: dict[str, VolumeFrequency] = field(default_factory=dict)

    def of(self, path_id: str) -> VolumeFrequency:
        """The frequency of a path. Raises `AvahazardError` where there is none."""
        if path_id not in self.fitted:
            rng = generator(self.seed, "frequency", path_id)
            if self.table is not None:
                found = self._of_table(path_id, self.table)
            elif self.depths is not None:
                found = self._of_snow(path_id, self.depths, rng)
            elif path_id in self.refused:
                raise self.refused[path_id]
            else:
                found = fit_volume_frequency(self.region, path_id, rng)
            self.fitted[path_id] = found
        return self.fitted[path_id]

    def _of_table(
        self, path_id: str, table: dict[str, list[tuple[float, float]]]
    ) -> VolumeFrequency:
        if path_id not in table:
            raise AvahazardError(
                f"The table {self.source.table} has no row of path {path_id}.",
                "Add its return periods and volumes, or name other paths with --path.",
            )
        return table_frequency(path_id, table[path_id])

    def _of_snow(
        self, path_id: str, depths: dict[str | None, Floats], rng: np.random.Generator
    ) -> VolumeFrequency:
        if path_id not in self.areas:
            raise AvahazardError(
                f"Path {path_id} has no {RELEASE_AREA}.",
                "Add this column to paths.csv and import it with --update.",
            )
        own = depths.get(path_id, depths.get(None))
        if own is None:
            raise AvahazardError(
                f"The file {self.source.snowfall} has no snow depth for path {path_id}.",
                "Add its rows, or rows without a path_id, which hold for all.",
            )
        record = self.region.records.get(path_id)
        ratio = self.source.density_ratio
        return snowfall_frequency(path_id, own, self.areas[path_id], ratio, record, rng)

    def rate_alone(self, path_id: str) -> EventVolumes | None:
        """The rate of a path by its record, for models to which volume does not matter.

        None where the path has no record.
        """
        record = self.region.records.get(path_id)
        if record is None:
            return None
        rng = generator(self.seed, "rate", path_id)
        rate = rng.gamma(record.n_events + 0.5, 1.0 / record.n_years, N_DRAWS)
        return replace(one_volume(ANY_VOLUME_M3, N_DRAWS), rate=rate, seen_only=True)

    def extrapolated(self, path_id: str, return_period: float) -> bool:
        """Whether a return period (years) is too long for what is known of a path."""
        try:
            return self.of(path_id).extrapolated(return_period)
        except AvahazardError:
            # A rate alone.
            return return_period > 2 * self.region.records[path_id].n_years


def volume_frequencies(
    known: KnownVolumes, seed: int, source: VolumeSource | None = None
) -> Frequencies:
    """The frequencies of all paths. Raises `AvahazardError` for a file that cannot be read."""
    source = source or VolumeSource()
    region = region_of(known.records, source.family, source.threshold_m3)
    if source.table is None and source.snowfall is None:
        # Now, while every worker is free: each would look at all paths for itself.
        region.together()
    return Frequencies(
        region=region,
        refused=known.refused,
        seed=seed,
        source=source,
        table=None if source.table is None else read_return_volumes(source.table),
        depths=None if source.snowfall is None else read_snow_depths(source.snowfall),
        areas=known.areas,
    )
