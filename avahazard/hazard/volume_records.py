"""What the records of paths say of how often avalanches come and how large they get.

Alone, and together of scale and shape.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.effects.record import MIN_SPREAD, variance_within
from avahazard.engine import spread_map
from avahazard.hazard.extremes import (
    LOG_SCALES,
    SHAPES,
    gev_likelihood,
    gpd_likelihood,
    over_locations,
)
from avahazard.hazard.volume_source import Family
from avahazard.records.collection import WINTER_STARTS, Covariate, Event, Path
from avahazard.records.errors import AvahazardError

WINDOWS = {
    (False, False): "observed_from to observed_to",
    (False, True): "observed_from to the last record of any path",
    (True, False): "the first record of any path to observed_to",
    (True, True): "the first to the last record of any path",
}
"""Where the observed years come from, by whether the path lacks each of the two columns."""


@dataclass(frozen=True, slots=True, eq=False)
class VolumeRecord:
    """The observed years of one path and their volumes.

    A year begins in month `year_starts` and is named by the calendar year in which it ends.
    `log_maxima` `[n_maxima]`: log of the largest volume (m3) of each year in which one was
    measured; `log_volumes` `[n_volumes]` those of all measured events; both with the standard
    deviations of the records. `n_events` dated records lie in the observed years, in
    `n_event_years` of them; `n_left_out` records have no date or lie outside. Years `gaps` between
    the first and the last were not observed. `window` says where the years come from.
    `event_years` `[n_events]` and `volume_years` `[n_volumes]` are those of records and volumes.
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
    gaps: frozenset[int] = frozenset()
    year_starts: int = WINTER_STARTS
    event_years: Ints = field(default_factory=lambda: np.empty(0, np.int64))
    volume_years: Ints = field(default_factory=lambda: np.empty(0, np.int64))

    @property
    def seasons(self) -> str:
        """What its years are called."""
        return "winters" if self.year_starts == WINTER_STARTS else "years"

    def observed_years(self) -> Ints:
        """The years, less those not observed."""
        years = np.arange(self.first_year, self.last_year + 1)
        return years[~np.isin(years, list(self.gaps))]

    @property
    def n_years(self) -> int:
        """Observed years, both ends counted, without the gaps."""
        return self.last_year - self.first_year + 1 - len(self.gaps)

    @property
    def known_years(self) -> tuple[float, float]:
        """Return periods that it says something of: up to twice its own length."""
        return 0.0, 2.0 * self.n_years

    @property
    def events_per_year(self) -> float:
        """Rate of events."""
        return self.n_events / self.n_years


@dataclass(frozen=True, slots=True, eq=False)
class DatedVolumes:
    """What a path's own records give: the years it was watched in, and its dated events.

    `year`, `month` `[n_events]` of their dates (month 1 of a year alone); `log_volume` (log m3,
    nan where it is not known) and its standard deviation `sigma`. `n_undated` have no date.
    """

    path_id: str
    observed_from: int | None
    observed_to: int | None
    not_observed: Covariate | None
    year: NDArray[np.int16]
    month: NDArray[np.int16]
    log_volume: Floats
    sigma: Floats
    n_undated: int

    def winters(self, starts: int) -> Ints:
        """Of each event the year in which its winter ends (`Event.winter`)."""
        return self.year + np.int64(0) + ((starts > 1) & (self.month >= starts))


def dated_volumes(path: Path, events: Sequence[Event]) -> DatedVolumes:
    """The dated events of a path, from all of its events."""
    dated = [event for event in events if event.date is not None]
    volumes = np.array([event.volume_m3 or np.nan for event in dated], np.float64)
    with np.errstate(invalid="ignore"):
        log_volume = np.log(np.where(volumes > 0.0, volumes, np.nan))
    return DatedVolumes(
        path_id=path.path_id,
        observed_from=path.observed_from,
        observed_to=path.observed_to,
        not_observed=path.covariates.get("not_observed"),
        year=np.array([event.year for event in dated], np.int16),
        month=np.array([int((event.date or "")[5:7] or 1) for event in dated], np.int16),
        log_volume=log_volume,
        sigma=np.array([event.volume_rel_sigma for event in dated], np.float64),
        n_undated=len(events) - len(dated),
    )


def data_window(paths: Iterable[DatedVolumes], starts: int) -> tuple[int, int] | None:
    """The first and the last winter in which any path has records; None without dates."""
    ends = [end for own in paths if len(own.year) for end in _ends(own.winters(starts))]
    return _ends(np.array(ends)) if ends else None


def _ends(winters: Ints) -> tuple[int, int]:
    return int(winters.min()), int(winters.max())


def volume_record(
    own: DatedVolumes, window: tuple[int, int] | None, starts: int = WINTER_STARTS
) -> VolumeRecord:
    """The volume record of a path; a year begins in month `starts`.

    Its years are the winters that end in `observed_from` to `observed_to`; an end that the path
    lacks is that of `window`, the winters in which any path has records. Raises `AvahazardError`
    where that gives no rate.
    """
    path_id, given = own.path_id, (own.observed_from, own.observed_to)
    hint = f"Give observed_from and observed_to of path {path_id}, or use --volume."
    if window is None or (not len(own.year) and None in given):
        if None in given:
            raise AvahazardError(f"No event of path {path_id} is dated: no rate of events.", hint)
        window = (0, 0)
    first, last = (end if at is None else at for at, end in zip(given, window, strict=True))
    if given == (None, None) and first == last:
        raise AvahazardError(
            f"All records of path {path_id} are of {first}, as are those of every path: no rate "
            "of events.",
            hint,
        )
    gaps = unobserved_years(path_id, own.not_observed) & set(range(first, last + 1))
    winters = own.winters(starts)
    inside = (winters >= first) & (winters <= last) & ~np.isin(winters, list(gaps))
    if not inside.any():
        raise AvahazardError(
            f"Path {path_id} has no dated event in its observed years {first} to {last}.", hint
        )
    measured = np.flatnonzero(inside & np.isfinite(own.log_volume))
    # The first of equal volumes of a winter.
    order = measured[np.lexsort((-own.log_volume[measured], winters[measured]))]
    _, largest = np.unique(winters[order], return_index=True)
    maxima = order[largest]
    return VolumeRecord(
        path_id=path_id,
        first_year=first,
        last_year=last,
        window=WINDOWS[given[0] is None, given[1] is None],
        n_events=int(inside.sum()),
        n_event_years=len(np.unique(winters[inside])),
        n_left_out=int(np.sum(~inside)) + own.n_undated,
        log_maxima=own.log_volume[maxima],
        maxima_sigma=own.sigma[maxima],
        log_volumes=own.log_volume[measured],
        volumes_sigma=own.sigma[measured],
        gaps=frozenset(gaps),
        year_starts=starts,
        event_years=winters[inside],
        volume_years=winters[measured],
    )


def unobserved_years(path_id: str, text: Covariate | None) -> set[int]:
    """Winters without observation by `not_observed`, such as `1914-1918;1943`; or refused."""
    if text is None:
        return set()
    if isinstance(text, float):
        text = f"{text:.0f}"
    years: set[int] = set()
    for part in str(text).split(";"):
        found = re.fullmatch(r"\s*(\d{4})(?:\s*[-–]\s*(\d{4}))?\s*", part)
        if found is None or int(found[2] or found[1]) < int(found[1]):
            raise AvahazardError(
                f"not_observed of path {path_id} is '{text}'.",
                "Give years and spans of years, such as 1914-1918;1943.",
            )
        years |= set(range(int(found[1]), int(found[2] or found[1]) + 1))
    return years


def without_record_error(records: Sequence[VolumeRecord]) -> list[VolumeRecord]:
    """The records with log volumes drawn towards each path's mean, by the error of the records.

    Recorded log volumes spread by their own error on top of the avalanches'. The avalanches' spread
    is that within paths, all together, less the mean square of the errors; a record with error σ is
    drawn in by √(spread² / (spread² + σ²)), so that what remains spreads as the avalanches do.
    """
    within = [r for r in records if len(r.log_volumes) >= 2]
    if not within:
        return list(records)
    error = float(np.mean(np.concatenate([r.volumes_sigma for r in within]) ** 2))
    spread2 = max(variance_within([r.log_volumes for r in within]) - error, MIN_SPREAD**2)

    def drawn(values: Floats, sigma: Floats, centre: float) -> Floats:
        return np.asarray(centre + np.sqrt(spread2 / (spread2 + sigma**2)) * (values - centre))

    freed = []
    for r in records:
        centre = float(r.log_volumes.mean()) if len(r.log_volumes) else 0.0
        maxima = drawn(r.log_maxima, r.maxima_sigma, centre)
        volumes = drawn(r.log_volumes, r.volumes_sigma, centre)
        freed.append(replace(r, log_maxima=maxima, log_volumes=volumes))
    return freed


FEWEST_TELLING = 3
"""Maxima, or excesses, from which a path informs others about scale and shape."""
IMPOSSIBLE = -1e6
"""Stands for every log likelihood under it, so that sums keep their digits."""
PATHS_AT_ONCE = 25
"""Paths whose log likelihoods are one piece of the sum of all, whoever adds them up."""


class PooledPaths(NamedTuple):
    """The sum of the log likelihoods `[n_scales, n_shapes]` of `n_paths` with `n_values` in all."""

    n_paths: int
    n_values: int
    likelihood: Floats


@dataclass(frozen=True, eq=False)
class RegionVolumes:
    """Volume records of all paths, and what they say of scale and shape.

    `records` are free of their errors; `recorded` are as they were: a GEV is fitted to these, with
    their errors in its likelihood.
    """

    records: dict[str, VolumeRecord]
    recorded: dict[str, VolumeRecord]
    family: Family
    threshold_m3: float | None

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

    def error(self, *path_ids: str) -> float:
        """What errors add to the spread of the yearly maxima of paths (log m3, sd).

        The largest of several errs less than each: as maxima spread less than all volumes. 0 for
        excesses over a threshold, which are free of errors.
        """
        sigma = np.concatenate([np.empty(0), *(self.recorded[p].maxima_sigma for p in path_ids)])
        if self.family == "gpd" or not len(sigma):
            return 0.0
        return self.of_maxima * float(np.sqrt(np.mean(sigma**2)))

    @cached_property
    def common_error(self) -> float:
        """The same of all paths together, of which each may ask."""
        return self.error(*self.recorded)

    @cached_property
    def of_maxima(self) -> float:
        """Spread of yearly maxima over that of all volumes, within paths; 1 at most."""
        known = self.recorded.values()
        maxima = np.sqrt(variance_within([r.log_maxima for r in known]))
        volumes = np.sqrt(variance_within([r.log_volumes for r in known]))
        return min(float(maxima / volumes), 1.0) if volumes > 0.0 else 1.0

    def likelihood(self, path_id: str) -> Floats:
        """Log likelihood over the grids of `extremes`, of a GEV over its location too."""
        return _likelihood(self.family, self.sample(path_id), self.error(path_id))

    @cached_property
    def together(self) -> PooledPaths:
        """What all paths with enough values say together, by all workers."""
        samples = [(self.sample(p), self.error(p)) for p in self.records]
        telling = [(values, error) for values, error in samples if len(values) >= FEWEST_TELLING]
        pieces = (telling[k : k + PATHS_AT_ONCE] for k in range(0, len(telling), PATHS_AT_ONCE))
        total = sum(spread_map(_told_by, self.family, pieces), NOTHING_TOLD)
        return PooledPaths(len(telling), sum(len(values) for values, _ in telling), total)

    def others(self, path_id: str, likelihood: Floats) -> PooledPaths:
        """The same without a path, whose `likelihood` is given."""
        n_paths, n_values, total = self.together
        n = len(self.sample(path_id))
        if n < FEWEST_TELLING:
            return self.together
        return PooledPaths(n_paths - 1, n_values - n, total - _told(self.family, likelihood))


NOTHING_TOLD = np.zeros((len(LOG_SCALES), len(SHAPES)))


def _told_by(family: Family, samples: Sequence[tuple[Floats, float]]) -> Floats:
    """What some paths say together, of each its sample and the error of that."""
    return sum((_told(family, _likelihood(family, *one)) for one in samples), NOTHING_TOLD)


def _told(family: Family, likelihood: Floats) -> Floats:
    """What the log likelihood of a path says of scale and shape alone."""
    own = over_locations(likelihood) if family == "gev" else likelihood
    return np.maximum(own, IMPOSSIBLE)


def _likelihood(family: Family, sample: Floats, error: float) -> Floats:
    return gpd_likelihood(sample) if family == "gpd" else gev_likelihood(sample, error)


def region_of(
    records: Sequence[VolumeRecord], family: Family = "gev", threshold_m3: float | None = None
) -> RegionVolumes:
    """Make the records ready for `fit_volume_frequency`, freed of their errors."""
    freed = {r.path_id: r for r in without_record_error(records)}
    return RegionVolumes(freed, {r.path_id: r for r in records}, family, threshold_m3)
