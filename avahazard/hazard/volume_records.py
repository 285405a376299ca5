"""What the records of paths say of how often avalanches come and how large they get.

Alone, and together of scale and shape.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.engine import spread_map
from avahazard.hazard.extremes import gev_likelihood, gpd_likelihood, over_locations
from avahazard.hazard.volume_source import Family
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.path import Path


@dataclass(frozen=True, slots=True, eq=False)
class VolumeRecord:
    """The observed years of one path and their volumes.

    `log_maxima` `[n_maxima]`: log of the largest volume (m3) of each calendar year in which one
    was measured; `log_volumes` `[n_volumes]` those of all measured events; both with the standard
    deviations of the records. `n_events` dated records lie in the observed years, in
    `n_event_years` of them; `n_left_out` records have no date or lie outside. `n_unobserved` years
    between the first and the last are gaps. `window` says where the years come from.
    """

    path_id: str
    first_year: int
    last_year: int
    window: str
    n_events: int
    n_event_years: int
    n_left_out: int
    log_maxima: Floats
    maxima_sigma: Floats
    log_volumes: Floats
    volumes_sigma: Floats
    n_unobserved: int = 0

    @property
    def n_years(self) -> int:
        """Observed years, both ends counted, without the gaps."""
        return self.last_year - self.first_year + 1 - self.n_unobserved

    @property
    def events_per_year(self) -> float:
        """Rate of events."""
        return self.n_events / self.n_years

    @property
    def event_year_chance(self) -> float:
        """Share of the observed years that had an event."""
        return self.n_event_years / self.n_years


def volume_record(path: Path, events: Sequence[Event]) -> VolumeRecord:
    """The volume record of a path from all its events.

    The years are `observed_from` to `observed_to`; an end that the path lacks is taken from its
    dated records. Raises `AvahazardError` where that gives no rate.
    """
    years = [event.year for event in events if event.year is not None]
    first = path.observed_from if path.observed_from is not None else min(years, default=None)
    last = path.observed_to if path.observed_to is not None else max(years, default=None)
    hint = f"Give observed_from and observed_to of path {path.path_id}, or use --volume."
    if first is None or last is None:
        raise AvahazardError(f"No event of path {path.path_id} is dated: no rate of events.", hint)
    if path.observed_from is None and path.observed_to is None and first == last:
        raise AvahazardError(
            f"All records of path {path.path_id} are of {first}: no rate of events.", hint
        )
    gaps = unobserved_years(path) & set(range(first, last + 1))
    inside = [
        e for e in events if e.year is not None and first <= e.year <= last and e.year not in gaps
    ]
    if not inside:
        raise AvahazardError(
            f"Path {path.path_id} has no dated event in its observed years {first} to {last}.", hint
        )
    measured = [e for e in inside if e.volume_m3 is not None and e.volume_m3 > 0]
    log_volumes = np.log(np.array([e.volume_m3 for e in measured], np.float64))
    sigma = np.array([e.volume_rel_sigma for e in measured], np.float64)
    largest: dict[int, int] = {}
    for k, event in enumerate(measured):
        if event.year is not None and (
            event.year not in largest or log_volumes[k] > log_volumes[largest[event.year]]
        ):
            largest[event.year] = k
    maxima = np.array([largest[year] for year in sorted(largest)], np.int64)
    return VolumeRecord(
        path_id=path.path_id,
        first_year=first,
        last_year=last,
        window=_window(path),
        n_events=len(inside),
        n_event_years=len({event.year for event in inside}),
        n_left_out=len(events) - len(inside),
        log_maxima=log_volumes[maxima],
        maxima_sigma=sigma[maxima],
        log_volumes=log_volumes,
        volumes_sigma=sigma,
        n_unobserved=len(gaps),
    )


def unobserved_years(path: Path) -> set[int]:
    """Years in which nobody looked, from the path's column `not_observed`: `1914-1918;1943`.

    Raises `AvahazardError` where the column does not read so.
    """
    text = path.covariates.get("not_observed")
    if text is None:
        return set()
    if isinstance(text, float):
        text = f"{text:.0f}"
    years: set[int] = set()
    for part in text.split(";"):
        found = re.fullmatch(r"\s*(\d{4})(?:\s*[-–]\s*(\d{4}))?\s*", part)
        if found is None or int(found[2] or found[1]) < int(found[1]):
            raise AvahazardError(
                f"not_observed of path {path.path_id} is '{text}'.",
                "Give years and spans of years, such as 1914-1918;1943.",
            )
        years |= set(range(int(found[1]), int(found[2] or found[1]) + 1))
    return years


LEAST_SPREAD = 0.1
"""Smallest natural spread of log volume that is believed."""


def without_record_error(records: Sequence[VolumeRecord]) -> list[VolumeRecord]:
    """The records with log volumes drawn towards each path's mean, by the error of the records.

    Recorded log volumes spread by their own error on top of the avalanches'. The avalanches'
    spread is that within paths, all together, less the mean square of the errors; a record with
    error σ is drawn in by √(spread² / (spread² + σ²)), so that what remains spreads as the
    avalanches do.
    """
    within = [(r.log_volumes, r.volumes_sigma) for r in records if len(r.log_volumes) >= 2]
    if not within:
        return list(records)
    free = sum(len(v) - 1 for v, _ in within)
    total = sum(float(np.sum((v - v.mean()) ** 2)) for v, _ in within) / free
    error = float(np.mean(np.concatenate([s for _, s in within]) ** 2))
    spread2 = max(total - error, LEAST_SPREAD**2)

    def drawn(values: Floats, sigma: Floats, centre: float) -> Floats:
        return np.asarray(centre + np.sqrt(spread2 / (spread2 + sigma**2)) * (values - centre))

    return [
        replace(
            r,
            log_maxima=drawn(r.log_maxima, r.maxima_sigma, float(r.log_volumes.mean())),
            log_volumes=drawn(r.log_volumes, r.volumes_sigma, float(r.log_volumes.mean())),
        )
        if len(r.log_volumes)
        else r
        for r in records
    ]


def _window(path: Path) -> str:
    if path.observed_from is not None and path.observed_to is not None:
        return "observed_from to observed_to"
    if path.observed_from is not None:
        return "observed_from to its last record"
    if path.observed_to is not None:
        return "its first record to observed_to"
    return "the span of its records"


FEWEST_TELLING = 3
"""Maxima, or excesses, from which a path tells others of scale and shape."""
IMPOSSIBLE = -1e6
"""A log likelihood under this is one of nought: sums keep their digits."""
PATHS_AT_ONCE = 25
"""Paths whose log likelihoods are one piece of the sum of all, whoever adds them up."""


@dataclass(frozen=True, slots=True, eq=False)
class PooledPaths:
    """Sum of the log likelihoods of paths over the grid: of `n_paths` with `n_values` in all.

    `possible` sums those that are not nought, `n_impossible` counts the paths whose is, both
    `[n_scales, n_shapes]`: so one can be taken away again.
    """

    n_paths: int = 0
    n_values: int = 0
    possible: Floats | float = 0.0
    n_impossible: NDArray[np.int64] | int = 0

    def plus(self, more: PooledPaths, sign: int = 1) -> PooledPaths:
        """With other paths too, or without them (`sign` -1)."""
        return PooledPaths(
            self.n_paths + sign * more.n_paths,
            self.n_values + sign * more.n_values,
            self.possible + sign * more.possible,
            self.n_impossible + sign * more.n_impossible,
        )

    @property
    def likelihood(self) -> Floats:
        """The sum, -inf where a path has nought."""
        return np.where(self.n_impossible == 0, self.possible, -np.inf)


@dataclass(frozen=True, slots=True, eq=False)
class RegionVolumes:
    """Volume records of all paths, and what they say of scale and shape.

    `records` are free of their errors; `recorded` are as they were: a GEV is fitted to these, with
    their errors in its likelihood.
    """

    records: dict[str, VolumeRecord]
    recorded: dict[str, VolumeRecord]
    family: Family
    threshold_m3: float | None
    kept: dict[str, Any] = field(default_factory=dict, init=False)

    def sample(self, path_id: str) -> Floats:
        """The yearly maxima of a path, or the excesses over its threshold, of log volume."""
        if self.family == "gev":
            return self.recorded[path_id].log_maxima
        record = self.records[path_id]
        over = record.log_volumes - self.threshold(path_id)
        return np.asarray(over[over > 0.0])

    def threshold(self, path_id: str) -> float:
        """The log volume that excesses are counted from: the path's median where none is given."""
        if self.threshold_m3 is not None:
            return float(np.log(self.threshold_m3))
        values = self.records[path_id].log_volumes
        return float(np.median(values)) if len(values) else 0.0

    def error(self, path_id: str = "") -> float:
        """What errors add to the spread of the yearly maxima of a path, or of all (log m3, sd).

        The largest of several errs less than each: as maxima spread less than all volumes. 0 for
        excesses over a threshold, which are free of errors.
        """
        if self.family == "gpd":
            return 0.0
        if path_id:
            return self._error_of([self.recorded[path_id]])
        if "error" not in self.kept:
            self.kept["error"] = self._error_of(list(self.recorded.values()))
        return float(self.kept["error"])

    def _error_of(self, records: Sequence[VolumeRecord]) -> float:
        sigma = np.concatenate([np.empty(0), *(record.maxima_sigma for record in records)])
        return self._of_maxima * float(np.sqrt(np.mean(sigma**2))) if len(sigma) else 0.0

    @property
    def _of_maxima(self) -> float:
        """Spread of yearly maxima over that of all volumes, within paths; 1 at most; kept."""
        if "of maxima" not in self.kept:
            known = list(self.recorded.values())
            maxima = _spread_within([r.log_maxima for r in known])
            volumes = _spread_within([r.log_volumes for r in known])
            self.kept["of maxima"] = min(maxima / volumes, 1.0) if volumes > 0.0 else 1.0
        return float(self.kept["of maxima"])

    def likelihood(self, path_id: str) -> Floats:
        """Log likelihood over the grid of `shape_grid`, as far as it is not nought."""
        return _likelihood(self.family, self.sample(path_id), self.error(path_id))

    def tells(self, path_id: str) -> bool:
        """Whether a path has enough to tell others of scale and shape."""
        return len(self.sample(path_id)) >= FEWEST_TELLING

    def together(self) -> PooledPaths:
        """What all paths that tell say together, by all workers; kept."""
        if "together" not in self.kept:
            telling = [path_id for path_id in self.records if self.tells(path_id)]
            pieces = (telling[k : k + PATHS_AT_ONCE] for k in range(0, len(telling), PATHS_AT_ONCE))
            samples = ([(self.sample(p), self.error(p)) for p in piece] for piece in pieces)
            parts = spread_map(_told_by, self.family, samples)
            self.kept["together"] = _sum_of(parts)
        together: PooledPaths = self.kept["together"]
        return together

    def others(self, path_id: str, likelihood: Floats) -> PooledPaths:
        """The same without a path, whose `likelihood` is given."""
        if not self.tells(path_id):
            return self.together()
        own = _of_one(self.family, likelihood, len(self.sample(path_id)))
        return self.together().plus(own, -1)


def _sum_of(parts: Iterable[PooledPaths]) -> PooledPaths:
    """The sum of parts, added in their order."""
    return reduce(PooledPaths.plus, parts, PooledPaths())


def _told_by(family: Family, samples: Sequence[tuple[Floats, float]]) -> PooledPaths:
    """What some paths say together, of each its sample and the error of that."""
    return _sum_of(
        _of_one(family, _likelihood(family, sample, error), len(sample))
        for sample, error in samples
    )


def _of_one(family: Family, likelihood: Floats, n_values: int) -> PooledPaths:
    """What one path says of scale and shape alone, by its log `likelihood`."""
    own = over_locations(likelihood) if family == "gev" else likelihood
    impossible = own < IMPOSSIBLE
    return PooledPaths(1, n_values, np.where(impossible, 0.0, own), impossible.astype(np.int64))


def _likelihood(family: Family, sample: Floats, error: float) -> Floats:
    if family == "gpd":
        return gpd_likelihood(sample)
    return gev_likelihood(sample, least=IMPOSSIBLE, error=error)


def _spread_within(samples: Sequence[Floats]) -> float:
    """Standard deviation about the mean of each sample; 0 where none has two values."""
    free = sum(max(len(v) - 1, 0) for v in samples)
    total = sum(float(np.sum((v - v.mean()) ** 2)) for v in samples if len(v))
    return float(np.sqrt(total / free)) if free else 0.0


def region_of(
    records: Sequence[VolumeRecord], family: Family = "gev", threshold_m3: float | None = None
) -> RegionVolumes:
    """Make the records ready for `fit_volume_frequency`, freed of their errors."""
    freed = {r.path_id: r for r in without_record_error(records)}
    return RegionVolumes(freed, {r.path_id: r for r in records}, family, threshold_m3)
