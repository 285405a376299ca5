"""What is known of each event besides where it stopped: the columns that effects may use."""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from datetime import date
from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Bools, Floats, Ints
from avahazard.records.collection import Event, Path
from avahazard.records.conventions import WINDS
from avahazard.records.meanings import one_spelling

ORIENTATION = "orientation"
DIRECTION = re.compile(
    r"(?:^|_| )(?:dir|aspect|azimuth?|bearing|heading|retning|esposizione|eksposisjon)(?:$|_| )"
    r"|direction|direzione|richtung|exposition",
    re.IGNORECASE,
)
"""Names of columns that hold directions, in degrees from north or as NE."""
NORTH, EAST = "_north", "_east"
RELEASE_SIGMA = "release_sigma_m"
"""A column of events or paths: the error of the release elevation, and so no driver of friction."""

FALL_HEIGHT = "fall_height_m"
"""A column of events without a profile. It ends at the stop and so is an outcome: an effect may be
added by it, but none is proposed."""


@dataclass(frozen=True, eq=False)
class MeasuredTrack:
    """Speeds (m/s) `[n_speeds]` with their errors at places x (m) along one event, by its index.

    It was released at `release_x` (m) and came to rest at `stop_x`, or passed it, the end of the
    profile, where it `left`.
    """

    event: int
    x: Floats
    speed: Floats
    sigma: Floats
    release_x: float
    stop_x: float
    left: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class EventColumns:
    """Columns over events, each `[n_events]`; numbers are nan and texts '' where missing.

    `path_index` points into `paths` (-1: no path). `day_of_winter` counts from 1 November; `day`
    is the ordinal of the date. `winter`, from October to September, is named by the year in which
    it ends; where a year is all that is known it is that one, since most avalanches fall after New
    Year. `volume_error` is the stated error of the log volume. `height_over_length` is the fall of
    the recorded stop over its horizontal distance: the friction of a block on a straight line.
    `numbers` and `texts` hold every covariate of events and of their paths, `made` those `counted`.
    """

    event_id: tuple[str, ...]
    paths: tuple[str, ...]
    path_index: Ints
    year: Floats
    day_of_winter: Floats
    day: Floats
    winter: Floats
    location: NDArray[np.str_]
    log_volume: Floats
    volume_error: Floats
    release_elevation: Floats
    deposit_length: Floats
    stop_elevation: Floats
    stop_x: Floats
    height_over_length: Floats
    section: NDArray[np.str_]
    numbers: Mapping[str, Floats]
    texts: Mapping[str, NDArray[np.str_]]
    made: Mapping[str, Floats] = field(default_factory=dict)
    tracks: tuple[MeasuredTrack, ...] = ()

    def __len__(self) -> int:
        return len(self.event_id)

    def on_path(self, path: str) -> Bools:
        """Which events `[n_events]` are on a path, by its id."""
        index = self.paths.index(path) if path in self.paths else -2
        return np.asarray(self.path_index == index)

    def at(self, events: Ints) -> EventColumns:
        """Those of these `events` `[n]`, in this order, some perhaps several times; no tracks."""
        rows: dict[str, Any] = {}
        for name, value in ((f.name, getattr(self, f.name)) for f in fields(self)):
            if isinstance(value, Mapping):
                rows[name] = {key: column[events] for key, column in value.items()}
            elif isinstance(value, np.ndarray):
                rows[name] = value[events]
        return replace(self, **rows, event_id=tuple(self.event_id[i] for i in events), tracks=())


def build_columns(
    events: Sequence[Event],
    paths: Mapping[str, Path],
    release_elevation: Floats,
    height_over_length: Floats | None = None,
) -> EventColumns:
    """Columns of the events; `release_elevation` `[n_events]` is where the block starts (m)."""
    if height_over_length is None:
        height_over_length = np.full(len(events), np.nan)
    names = tuple(dict.fromkeys(e.path_id for e in events if e.path_id is not None))
    index = {name: k for k, name in enumerate(names)}
    its_path = [paths[e.path_id] if e.path_id else None for e in events]
    dates = [date.fromisoformat(e.date) if e.date and len(e.date) >= 10 else None for e in events]
    numbers, texts = _covariates(events, paths)

    def column(values: Iterable[float | None]) -> Floats:
        return np.array(list(values), np.float64)  # None becomes nan

    return EventColumns(
        event_id=tuple(e.event_id for e in events),
        paths=names,
        path_index=np.array([index.get(e.path_id or "", -1) for e in events], dtype=np.int64),
        year=column(e.year for e in events),
        day_of_winter=column(
            (d - date(d.year if d.month >= 11 else d.year - 1, 11, 1)).days if d else None
            for d in dates
        ),
        day=column(d.toordinal() if d else None for d in dates),
        winter=column(e.winter() for e in events),
        location=np.array([(p and p.location) or "" for p in its_path]),
        log_volume=column(np.log(e.volume_m3) if e.volume_m3 else None for e in events),
        volume_error=column(e.volume_rel_sigma for e in events),
        release_elevation=release_elevation,
        deposit_length=column(e.deposit_length_m for e in events),
        stop_elevation=column(e.runout_elevation_m for e in events),
        stop_x=column(e.runout_x_m for e in events),
        height_over_length=height_over_length,
        section=np.array([(p and p.section) or "" for p in its_path]),
        numbers=numbers,
        texts=texts,
    )


NEARBY_DAYS = 3
"""Days before and after, within which avalanches at one location count as nearby."""


def counted(columns: EventColumns, among: EventColumns) -> dict[str, Floats]:
    """Columns `[n_events]` that the records `among` make of these events; nan without a day.

    `order_in_winter` counts the avalanches of a path in a winter from 1; `days_since_last` is since
    the one before it there (nan for the first); `avalanches_nearby` are the others at its location
    within `NEARBY_DAYS`; `volume_in_winter` (log of m3) is what came down before, the first's own
    being nan. An event is one of `among`, or stands for one of them.
    """
    made = {name: np.full(len(columns), np.nan) for name in MADE}
    on_path, at_location = defaultdict(list), defaultdict(list)
    for path, winter, location, day, volume in _dated(among):
        if not np.isnan(day):
            on_path[path, winter].append((day, volume))
            at_location[location].append(day)
    for days in at_location.values():
        days.sort()
    for i, (path, winter, location, day, _) in enumerate(_dated(columns)):
        if np.isnan(day):
            continue
        before = [(its, volume) for its, volume in on_path[path, winter] if its < day]
        if path:
            made["order_in_winter"][i] = 1.0 + len(before)
        if path and before:
            made["days_since_last"][i] = day - max(its for its, _ in before)
            total = float(np.nansum([volume for _, volume in before]))
            made["volume_in_winter"][i] = np.log(total) if total > 0.0 else np.nan
        days = at_location[location]
        near = bisect_right(days, day + NEARBY_DAYS) - bisect_left(days, day - NEARBY_DAYS)
        made["avalanches_nearby"][i] = max(near - 1, 0)
    return made


def _dated(columns: EventColumns) -> Iterator[tuple[str, float, str, float, float]]:
    """Path ('': none), winter, location, day and volume (m3) of each event, nan if unknown."""
    paths = np.array([*columns.paths, ""])[columns.path_index]
    volume = np.exp(columns.log_volume)
    rows = (paths, columns.winter, columns.location, columns.day, volume)
    return zip(*(values.tolist() for values in rows), strict=True)


MADE = ("order_in_winter", "days_since_last", "avalanches_nearby", "volume_in_winter")


def _covariates(
    events: Sequence[Event], paths: Mapping[str, Path]
) -> tuple[dict[str, Floats], dict[str, NDArray[np.str_]]]:
    """Covariates by column: numbers where every value is one, else texts in one spelling."""
    of_path = {name: _of_path(paths[name]) for name in {e.path_id for e in events} if name}
    rows = [{**(of_path[e.path_id] if e.path_id else _of_line(e)), **e.covariates} for e in events]
    numbers: dict[str, Floats] = {}
    texts: dict[str, NDArray[np.str_]] = {}
    for column in dict.fromkeys(key for row in rows for key in row if key != RELEASE_SIGMA):
        values = [row.get(column) for row in rows]
        if all(v is None or isinstance(v, int | float) for v in values):
            numbers[column] = np.array(values, np.float64)
        else:
            written = ["" if v is None else str(v) for v in values]
            spelled = one_spelling(written)
            texts[column] = np.array([spelled.get(text, "") for text in written])
    for column in filter(DIRECTION.search, [*numbers, *texts]):
        facing = numbers.get(column)
        if facing is None:
            facing = np.array([facing_of(text) for text in texts[column]])
        # A part that is in the file goes before what is made, and is no direction itself.
        made = column != ORIENTATION and not column.endswith((NORTH, EAST))
        if made and np.any(np.isfinite(facing)):
            angle = np.radians(facing)
            numbers.setdefault(column + NORTH, np.cos(angle))
            numbers.setdefault(column + EAST, np.sin(angle))
    return numbers, texts


def facing_of(text: str) -> float:
    """A direction such as NE in degrees from north; nan for what is none."""
    wind = text.strip().upper()
    return 360.0 * WINDS.index(wind) / len(WINDS) if wind in WINDS else np.nan


def _of_path(path: Path) -> dict[str, float | str | None]:
    """What is known of a path that may drive friction; how far it faces north and east, -1 to 1."""
    own = {ORIENTATION: path.orientation, "catchment_ha": path.catchment_ha}
    facing = np.radians(facing_of(path.orientation or ""))
    if np.isfinite(facing):
        own["northness"], own["eastness"] = round(np.cos(facing), 3), round(np.sin(facing), 3)
    return {**{name: value for name, value in own.items() if value is not None}, **path.covariates}


def _of_line(event: Event) -> dict[str, float | str | None]:
    """What an event without a profile has instead of a path's columns: how far it fell."""
    return {} if event.fall_height_m is None else {FALL_HEIGHT: event.fall_height_m}


NO_EVENTS = build_columns((), {}, np.empty(0))
"""The columns of no events."""


def friction_by_paths(columns: EventColumns) -> tuple[Bools, Floats, Floats]:
    """Events with a recorded H/L `[n_events]`, its log, and columns of path and volume."""
    use = columns.height_over_length > 0.0
    recorded = columns.log_volume[np.isfinite(columns.log_volume)]
    mean = float(np.mean(recorded)) if len(recorded) else 0.0
    groups = columns.path_index[use, None] == np.unique(columns.path_index[use])
    volume = np.nan_to_num(columns.log_volume[use], nan=mean)
    rest = np.column_stack([groups, volume]).astype(np.float64)
    return use, np.log(columns.height_over_length[use]), rest


def where_it_acts(paths: Sequence[str], nats: Callable[[Sequence[str]], float]) -> list[str]:
    """The paths on which something acts by itself, of those on which it may.

    `nats` says what it explains on some of them, its parameters paid for. Those on which it
    explains most come first; which and how many they are has a price too.
    """
    ranked = sorted(paths, key=lambda path: -nats([path]))
    first = [ranked[:n] for n in range(1, len(ranked) + 1)]
    worth = [nats(some) - np.log(comb(len(paths), len(some))) for some in first]
    return sorted(first[int(np.argmax(worth))])
