"""The population of true volumes that recorded ones come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.stated_errors import MIN_SPREAD, variance_within
from avahazard.inference.model.largest_volume import cut_normals, largest_volume
from avahazard.inference.model.volume_shape import VolumeShape, volume_shape

NEEDED = 5.0
"""Nats by which another population must be likelier than a lognormal."""
LEAST_SPREAD = 0.5
"""Root mean square errors that true volumes must spread over for anything but that to be told."""
EVENTS_AT_ONCE = 2000
"""Events whose true volumes are looked for together."""


@dataclass(frozen=True, slots=True, eq=False)
class VolumeRecords:
    """What is written of volumes, each `[n_events]`: `log_volume` (log m3, or nan).

    `sigma` is its stated error, `path` the place of its path among the `paths`, of which the first,
    '', is none. `told` is what something else that goes with the volume tells of it
    (`told_by_stand_in`), where that is asked.
    """

    log_volume: Floats
    sigma: Floats
    path: Ints
    paths: tuple[str, ...]
    told: Floats | None = None

    def by_path(self) -> list[Floats]:
        """The recorded log volumes of each of the `paths`, those that are known."""
        have = np.isfinite(self.log_volume)
        path = self.path[have]
        ends = np.cumsum(np.bincount(path, minlength=len(self.paths)))
        return np.split(self.log_volume[have][np.argsort(path, kind="stable")], ends[:-1])


@dataclass(frozen=True, slots=True, eq=False)
class Population:
    """True volumes of a path lie about its `centre` (log m3) with standard deviation `spread`.

    `shape` is how, in spreads; None: they are lognormal, cut at the `largest` (log m3) that there
    is. `known` is False where no event has a volume. All are told by `records`, with `factor` times
    their stated errors. `overall` is the mean of the centres.
    """

    records: VolumeRecords
    factor: float
    centre: dict[str, float]
    spread: float
    known: bool
    shape: VolumeShape | None = None
    largest: float = np.inf
    overall: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "overall", float(np.mean(list(self.centre.values()))))

    def given(self, records: VolumeRecords) -> tuple[Floats, Floats]:
        """Mean and standard deviation of log true volumes, given what is written of each event.

        They are those of normals that are not cut yet.
        """
        recorded, sigma = records.log_volume, self.factor * records.sigma
        have = np.isfinite(recorded)
        centre = self.centres(records.paths)[records.path]
        spread2 = np.full(len(have), self.spread**2)
        by_shape = have & (sigma > 0.0)
        if records.told is not None:
            some = np.isfinite(records.told)
            centre[some] += records.told[some]
            # What is told is no spread any more, and of what is left no shape is known.
            explained = float(np.mean(records.told[some] ** 2)) if np.any(some) else 0.0
            spread2[some] = max(self.spread**2 - explained, MIN_SPREAD**2)
            by_shape = by_shape & ~some
        trust = np.where(have, spread2 / (spread2 + sigma**2), 0.0)
        mean = centre + trust * (np.where(have, recorded, centre) - centre)
        sd = np.sqrt(spread2 * (1.0 - trust))
        if self.shape is None:
            return mean, sd
        for part in np.array_split(np.flatnonzero(by_shape), 1 + len(have) // EVENTS_AT_ONCE):
            away = (recorded[part] - centre[part]) / self.spread
            found = self.shape.moments(away, sigma[part] / self.spread)
            mean[part] = centre[part] + self.spread * found[0]
            sd[part] = self.spread * found[1]
        return mean, sd

    def centres(self, paths: Sequence[str]) -> Floats:
        """The centres of `paths`; of one that is not known the mean of all."""
        return np.array([self.centre.get(name, self.overall) for name in paths])


def population_of(records: VolumeRecords) -> Population:
    """Centres, drawn a little to the overall mean, and one spread, by moments.

    Lognormal, but where the records speak for a largest volume, or another shape.
    """
    found = _by_moments(records, 1.0)
    if not found.known or found.spread == MIN_SPREAD:
        return found
    have = np.isfinite(records.log_volume)
    recorded, sigma, path = records.log_volume[have], records.sigma[have], records.path[have]
    if found.spread < LEAST_SPREAD * float(np.sqrt(np.mean(sigma**2))):
        return found
    centre = found.centres(records.paths)
    away = (recorded - centre[path]) / found.spread
    largest, for_cut = largest_volume(recorded, sigma, path, centre, found.spread)
    shape, for_shape = volume_shape(away, sigma / found.spread)
    if max(for_cut, for_shape) < NEEDED:
        return found
    if for_shape > for_cut:
        return replace(found, shape=shape)
    return _cut(found, largest)


@lru_cache(maxsize=2)
def with_errors(population: Population, factor: float) -> Population:
    """The same where records' errors are `factor` times as large as stated.

    Their scatter stays, and how the population differs from a lognormal. The last are kept: every
    path of a region is read in the light of the same.
    """
    if population.factor == factor:
        return population
    found = _by_moments(population.records, factor)
    if population.shape is not None:
        return replace(found, shape=population.shape)
    return _cut(found, population.largest)


def _cut(found: Population, largest: float) -> Population:
    """What gives these moments where it is cut at the `largest` volume."""
    records = found.records
    have = np.isfinite(records.log_volume)
    count = np.bincount(records.path[have], minlength=len(records.paths))
    cut = cut_normals(found.centres(records.paths), count, found.spread, largest)
    centre = dict(zip(records.paths, map(float, cut.centre), strict=True))
    return replace(found, centre=centre, spread=cut.spread, largest=largest)


def _by_moments(records: VolumeRecords, factor: float) -> Population:
    """Centres and spread, where records have `factor` times their stated errors."""
    recorded, sigma = records.log_volume, factor * records.sigma
    have = np.isfinite(recorded)
    if not np.any(have):
        nowhere = {"": float(np.log(1e4))}
        return Population(records, factor, nowhere, MIN_SPREAD, known=False)
    overall = float(np.mean(recorded[have]))
    members = dict(zip(records.paths, records.by_path(), strict=True))
    total2 = variance_within(list(members.values()))
    spread2 = max(total2 - float(np.mean(sigma[have] ** 2)), MIN_SPREAD**2)
    between2 = max(float(np.var([np.mean(v) for v in members.values() if len(v)])), MIN_SPREAD**2)
    centre = {}
    for name, values in members.items():
        trust = between2 / (between2 + max(total2, spread2) / len(values)) if len(values) else 0.0
        centre[name] = overall + trust * (float(np.mean(values)) - overall if trust else 0.0)
    return Population(records, factor, centre, float(np.sqrt(spread2)), known=True)
