"""What a path's records say about how often avalanches come and how large they get."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from avahazard.arrays import Floats
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
