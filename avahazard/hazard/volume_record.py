"""What a path's records say about how often avalanches come and how large they get."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.path import Path

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class VolumeRecord:
    """The observed years of one path and their largest volumes.

    `log_maxima` `[n_maxima]`: log of the largest volume (m3) of each calendar year in which one
    was measured. `n_events` dated records lie in the observed years, in `n_event_years` of them;
    `n_left_out` records have no date or lie outside. `window` says where the years come from.
    """

    path_id: str
    first_year: int
    last_year: int
    window: str
    n_events: int
    n_event_years: int
    n_left_out: int
    log_maxima: Floats

    @property
    def n_years(self) -> int:
        """Observed years, both ends counted."""
        return self.last_year - self.first_year + 1

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
    inside = [e for e in events if e.year is not None and first <= e.year <= last]
    if not inside:
        raise AvahazardError(
            f"Path {path.path_id} has no dated event in its observed years {first} to {last}.", hint
        )
    largest: dict[int, float] = {}
    for event in inside:
        if event.year is not None and event.volume_m3 is not None and event.volume_m3 > 0:
            largest[event.year] = max(largest.get(event.year, 0.0), event.volume_m3)
    return VolumeRecord(
        path_id=path.path_id,
        first_year=first,
        last_year=last,
        window=_window(path),
        n_events=len(inside),
        n_event_years=len({event.year for event in inside}),
        n_left_out=len(events) - len(inside),
        log_maxima=np.log([largest[year] for year in sorted(largest)]),
    )


def _window(path: Path) -> str:
    if path.observed_from is not None and path.observed_to is not None:
        return "observed_from to observed_to"
    if path.observed_from is not None:
        return "observed_from to its last record"
    if path.observed_to is not None:
        return "its first record to observed_to"
    return "the span of its records"
