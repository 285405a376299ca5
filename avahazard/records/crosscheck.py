"""Checks between records: references, places on the profiles, contradictions, and doubts."""

import math
from collections.abc import Collection, Hashable, Iterable, Set
from dataclasses import fields
from functools import lru_cache
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.notes import ENGLISH, Note
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Event, Path, Profile, Speed
from avahazard.records.intake import KEYS, Intake, Key, speed_key
from avahazard.records.meanings import MEANINGS, one_spelling

Fault = tuple[str, float, str]  # column, value, what would be accepted
Rises = tuple[tuple[float, float], ...]

# So many standard deviations of the ground must a path rise before two places count; and amid the
# path by as much as no stop is known better.
RISE_SD = 3.0
LEAST_RISE_M = 10.0

N_SIGMA = 3.0
# Elevations read from another map than the profile differ by about this much.
MAP_TOLERANCE_M = 30.0

# Profiles that are looked at once: events come in any order of a region's paths.
KEPT = 20_000


def stop_fault(event: Event, profile: Profile) -> Fault | None:
    """Return what is wrong with the stop of `event`, None when it is one place on `profile`.

    Outside the profile is accepted within `N_SIGMA` of the record, and for events beyond it.
    """
    if event.left_profile:
        return None
    slack = N_SIGMA * event.runout_sigma_m
    place = event.runout_x_m, event.runout_elevation_m
    return _off_the_profile(profile, "runout_", place, (slack, slack), ", or left_profile 1")


def speed_fault(speed: Speed, profile: Profile) -> Fault | None:
    """Return what is wrong with the place of `speed`."""
    place = speed.x_m, speed.elevation_m
    return _off_the_profile(profile, "", place, (0.0, MAP_TOLERANCE_M), "")


def _off_the_profile(
    profile: Profile,
    kind: str,
    place: tuple[float | None, float | None],
    slack: tuple[float, float],
    remedy: str,
) -> Fault | None:
    """Return what is wrong with a distance, or else an elevation, of columns that begin so."""
    x, elevation = place
    if x is not None:
        column, value = f"{kind}x_m", x
        low, high = float(profile.x_m[0]), float(profile.x_m[-1])
    elif elevation is not None:
        column, value = f"{kind}elevation_m", elevation
        low, high = _heights(profile)
        if on_counter_slope(elevation, profile):
            twice = "too: the profile rises again, and reaches this elevation at two places"
            return column, value, f"{kind}x_m {twice}{_crossings(elevation, profile)}"
    else:
        return None
    far = slack[0] if x is not None else slack[1]
    if low - far <= value <= high + far:
        return None
    return column, value, f"{low:g} to {high:g} (the profile){remedy}"


def release_fault(record: Event | Path, profile: Profile) -> Fault | None:
    """Return what is wrong with the release elevation of an event or a path."""
    release = record.release_elevation_m
    if release is None:
        return None
    low, high = _heights(profile)
    if not low - MAP_TOLERANCE_M <= release <= high + MAP_TOLERANCE_M:
        return "release_elevation_m", release, f"{low:g} to {high:g} (the profile)"
    if isinstance(record, Event) and record.runout_x_m is None and not record.left_profile:
        stop = record.runout_elevation_m
        if stop is not None and stop > release + N_SIGMA * record.runout_sigma_m:
            return "release_elevation_m", release, "an elevation above that of the runout"
    return None


def on_counter_slope(elevation_m: float, profile: Profile) -> bool:
    """Whether ground that rises by more than its error reaches `elevation_m` again."""
    # Most elevations lie on no rise of the points themselves, and most profiles have none.
    return all(
        any(low < elevation_m <= high for low, high in rises(profile))
        for rises in (_rises_of_points, _rises)
    )


def _crossings(elevation_m: float, profile: Profile) -> str:
    """Where the points of a profile pass an elevation."""
    x, above = profile.x_m, profile.y_m - elevation_m
    k = np.flatnonzero(np.diff(np.sign(above)))
    places = np.unique(np.round(x[k] + np.diff(x)[k] * above[k] / (above[k] - above[k + 1])))
    return f": x = {ENGLISH.listed([f'{x:.0f}' for x in places])} m" if len(places) > 1 else ""


@lru_cache(maxsize=KEPT)
def _heights(profile: Profile) -> tuple[float, float]:
    """The lowest and the highest point (m)."""
    return float(profile.y_m.min()), float(profile.y_m.max())


@lru_cache(maxsize=KEPT)
def _rises_of_points(profile: Profile) -> Rises:
    """From where to where (m) the points rise until they lie lower again."""
    parts = _risen(profile.y_m, profile.y_m)
    return tuple((float(y[0]), float(y.max())) for y in parts if y.max() > y[0])


@lru_cache(maxsize=KEPT)
def _rises(profile: Profile) -> Rises:
    """The same of the ground, by more than its error."""
    smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    height = smooth.height(profile.x_m)
    sd = np.zeros(len(height))
    if smooth.posterior is not None:
        sd = smooth.posterior.sd(profile.x_m)
    found = []
    for part in _risen(height, np.arange(len(height))):
        rise = height[part] - height[part[0]]
        if np.any(rise > RISE_SD * np.hypot(sd[part], sd[part[0]])):
            points = profile.y_m[part]
            found.append((float(points.min()), float(points.max())))
    return tuple(found)


def _risen(height: Floats, values: NDArray[Any]) -> list[NDArray[Any]]:
    """The values along each rise that counts, from its valley on until the ground is lower."""
    valleys = np.flatnonzero(np.diff(np.minimum.accumulate(height), prepend=np.inf) < 0.0)
    ends = [*valleys[1:].tolist(), len(height)]
    return [
        values[valley:end]
        for valley, end in zip(valleys.tolist(), ends, strict=True)
        if end == len(height) or height[valley:end].max() - height[valley] > LEAST_RISE_M
    ]


# Two measurements of one volume differ by this factor at least before one of them is wrong.
VOLUME_FACTOR = 2.0


def volume_fault(event: Event) -> Fault | None:
    """Return what is wrong where the volume is not that of its deposit, V = L W H / 2."""
    deposit = event.deposit_m3
    if event.volume_m3 is None or deposit is None:
        return None
    allowed = max(math.log(VOLUME_FACTOR), N_SIGMA * event.volume_rel_sigma)
    if abs(math.log(event.volume_m3) - math.log(deposit)) > allowed:
        return "volume_m3", event.volume_m3, Note("volume_of_deposit", deposit=deposit)
    return None


def place_fault(event: Event, path: Path | None, profile: Profile) -> Fault | None:
    """Return what is wrong where the places of a stop contradict each other or the release."""
    slack = N_SIGMA * event.runout_sigma_m
    if event.left_profile:
        return _stopped_before_the_end(event, profile, slack)
    x, elevation = event.runout_x_m, event.runout_elevation_m
    if x is not None and elevation is not None:
        low, high = _elevations(profile, x - slack, x + slack)
        if not low - MAP_TOLERANCE_M <= elevation <= high + MAP_TOLERANCE_M:
            there = float(np.interp(x, profile.x_m, profile.y_m))
            return "runout_elevation_m", elevation, Note("elevation_there", there=there, x=x)
    return _above_the_release(event, path, profile, slack)


def unseen_elevation(event: Event, path: Path, profile: Profile | None) -> float | None:
    """Elevation (m) of a stop that is surely over its path's detection limit; or None."""
    limit, slack = path.observed_below_m, N_SIGMA * event.runout_sigma_m
    if limit is None or event.left_profile:
        return None
    elevation = event.runout_elevation_m
    if event.runout_x_m is not None and profile is not None:
        start = float(profile.x_m[0])
        elevation = _elevations(profile, start, max(event.runout_x_m + slack, start))[0]
        slack = 0.0
    elif elevation is not None and profile is not None and on_counter_slope(elevation, profile):
        return None
    return elevation if elevation is not None and elevation > limit + slack else None


def _stopped_before_the_end(event: Event, profile: Profile, slack: float) -> Fault | None:
    x, elevation = event.runout_x_m, event.runout_elevation_m
    if x is not None:
        return ("runout_x_m", x, Note("not_beyond")) if x < profile.x_m[-1] - slack else None
    highest = profile.y_m[-1] + slack + MAP_TOLERANCE_M
    if elevation is None or elevation <= highest or on_counter_slope(elevation, profile):
        return None
    return "runout_elevation_m", elevation, Note("not_beyond")


def _above_the_release(
    event: Event, path: Path | None, profile: Profile, slack: float
) -> Fault | None:
    """A release is the event's own, else the path's; the top of the profile is above every stop."""
    own = event.release_elevation_m
    release = path.release_elevation_m if path is not None and own is None else own
    if release is None:
        return None
    if event.runout_x_m is not None:
        # The lowest that the stop may lie at, given its error.
        column, value = "runout_x_m", event.runout_x_m
        lowest = _elevations(profile, value - slack, value + slack)[0] - MAP_TOLERANCE_M
    elif event.runout_elevation_m is not None:
        column, value = "runout_elevation_m", event.runout_elevation_m
        lowest = value - slack
    else:
        return None
    if lowest <= release:
        return None
    whose = Note("release_of_path") if own is None else "release_elevation_m"
    return column, value, Note("below_release", release=release, whose=whose)


def _elevations(profile: Profile, first: float, last: float) -> tuple[float, float]:
    """The lowest and highest elevation of the profile from `first` to `last`."""
    inside = (profile.x_m > first) & (profile.x_m < last)
    ends = np.interp([first, last], profile.x_m, profile.y_m)
    every = np.concatenate([profile.y_m[inside], ends])
    return float(every.min()), float(every.max())


def check_references(intake: Intake, path_ids: Set[str], event_ids: Set[str]) -> None:
    """Refuse events of a path, and speeds of an event, that neither files nor database have."""
    named = {p.name: p.path_id for p in (*intake.known.paths, *intake.records.paths) if p.name}
    for event in intake.records.events:
        if event.path_id is not None and event.path_id not in path_ids:
            accepted = "a path_id of these files or of the database"
            if event.path_id in named:
                accepted += f", such as {named[event.path_id]}, whose name this is"
            intake.refuse(("event", event.event_id), "path_id", event.path_id, accepted)
    for speed in intake.records.speeds:
        if speed.event_id not in event_ids:
            accepted = "an event_id of these files or of the database"
            intake.refuse(speed_key(speed), "event_id", speed.event_id, accepted)


def check_places(intake: Intake) -> None:
    """Refuse stops, releases and speeds off the profile of their path, and contradictory events.

    Stored records are checked again where their path has another profile or release now.
    """
    new, known = intake.records, intake.known
    paths = {p.path_id: p for p in (*known.paths, *new.paths)}
    events = {e.event_id: e for e in (*known.events, *new.events)}
    speeds = {speed_key(s): s for s in (*known.speeds, *new.speeds)}
    # Of points that do not lie on the Earth, which are refused already, nothing fits.
    low, high = MEANINGS["y_m"].possible
    profiles = {
        p.path_id: p
        for p in (*known.profiles, *new.profiles)
        if low <= p.y_m.min() and p.y_m.max() <= high
    }
    read = {key_of(record) for kind, key_of in KEYS.items() for record in getattr(new, kind)}
    released = {p.path_id: p.release_elevation_m for p in known.paths}
    # A path that is new has no stored events.
    moved = {p.path_id for p in new.profiles}
    moved |= {p.path_id for p in new.paths if p.release_elevation_m != released.get(p.path_id)}
    found: list[tuple[Key, Fault | None]] = []
    for path_id, path in paths.items():
        if path_id in profiles and read & {("path", path_id), ("profile", path_id)}:
            found.append((("path", path_id), release_fault(path, profiles[path_id])))
    for event_id, event in events.items():
        key: Key = ("event", event_id)
        faults = [volume_fault(event)] if key in read else []
        profile = profiles.get(event.path_id or "")
        if profile is not None and (key in read or event.path_id in moved):
            # Each place by itself, else with one another.
            alone = [stop_fault(event, profile), release_fault(event, profile)]
            of_path = paths.get(profile.path_id)
            faults += alone if any(alone) else [place_fault(event, of_path, profile)]
        found += [(key, fault) for fault in faults]
    for key, speed in speeds.items():
        of_event = events.get(speed.event_id)
        path_id = (of_event and of_event.path_id) or ""
        if path_id in profiles and read & {key, ("event", speed.event_id), ("profile", path_id)}:
            found.append((key, speed_fault(speed, profiles[path_id])))
    for key, fault in found:
        if fault is not None:
            intake.refuse(key, *fault)


def check_one_scale(intake: Intake) -> None:
    """Refuse H/L alone beside runouts in metres: no score could be taken over both."""
    read = {e.event_id for e in intake.records.events}
    stored = [e for e in intake.known.events if e.event_id not in read]
    ratios = [e for e in intake.records.events if e.in_ratio]
    others = [e for e in intake.records.events if not e.in_ratio]
    remedy = "or a database of its own: H/L and metres have no score in common"
    if ratios and (others or any(not e.in_ratio for e in stored)):
        first = ratios[0]
        accepted = f"H or L in metres with it, as the other events have, {remedy}"
        intake.refuse(("event", first.event_id), "h_over_l", first.h_over_l or "", accepted)
    elif others and any(e.in_ratio for e in stored):
        accepted = f"h_over_l alone, as the stored events have, {remedy}"
        intake.refuse(("event", others[0].event_id), "event_id", others[0].event_id, accepted)


# Records that are probably wrong, though possible, get a note on import. Lists from several offices
# have an avalanche under two ids: what varies between avalanches is then zero between such two,
# storms seem to share their snow, and intervals are too narrow. Volumes that dwarf all others are
# slips of units more often than avalanches. Stops whose error is as large as their path is high
# tell nothing of friction.
A_DAY = len("1999-01-31")
COLUMNS = attrgetter(*(f.name for f in fields(Event) if f.name not in ("event_id", "covariates")))
"""All that the forms say of an event but its id."""
STOP = attrgetter(
    "runout_elevation_m", "runout_x_m", "fall_height_m", "runout_length_m", "h_over_l"
)


def repeated(events: Iterable[Event], new: Collection[str] | None = None) -> list[Note]:
    """Notes on events that are alike in path, day and stop, or in all but their id.

    With `new` only on groups of which one has an id among these.
    Two avalanches may stop at one rounded place in the same year: where the day is not known, they
    must have the same volume and all else too. Those without a recorded stop are never alike.
    """
    groups: dict[Hashable, list[str]] = {}
    for event in events:
        if (key := _told_by(event)) is not None:
            groups.setdefault(key, []).append(event.event_id)
    return [
        Note("recorded_twice", " = ".join(ids))
        for ids in groups.values()
        if len(ids) > 1 and (new is None or any(event_id in new for event_id in ids))
    ]


def spelled_variously(events: Iterable[Event]) -> list[Note]:
    """Notes on columns some of whose values differ in spelling alone, and are taken for one."""
    texts: dict[str, list[str]] = {}
    for event in events:
        for column, value in event.covariates.items():
            if isinstance(value, str):
                texts.setdefault(column, []).append(value)
    found = []
    for column, values in texts.items():
        others: dict[str, list[str]] = {}
        for text, kept in one_spelling(values).items():
            others.setdefault(kept, []).extend([text] * (text != kept))
        parts = [f"{kept} ({', '.join(sorted(more))})" for kept, more in others.items() if more]
        if parts:
            found.append(Note("spelled_variously", column, parts=parts))
    return found


def _told_by(event: Event) -> Hashable | None:
    """What distinguishes an event from others, None where too little is known."""
    stop = STOP(event)
    if all(value is None for value in stop):
        return None
    if event.date is not None and len(event.date) == A_DAY and event.path_id is not None:
        return event.path_id, event.date, stop
    if event.volume_m3 is None:
        return None
    # A record read from a file and one from the database may differ in the order of columns.
    own = tuple(sorted((name, str(value)) for name, value in event.covariates.items()))
    return *COLUMNS(event), own


FACTOR = 100.0
"""How many times the next smaller volume one must be to be suspect."""
MOST = 0.05
"""Where more than this share of the records lie beyond a gap, they are another kind of flow."""
FEWEST = 5


def dwarfing(log_volume: Floats) -> Ints:
    """Indices of the few volumes `[n]` (log m3, nan if unknown) beyond a gap, largest first."""
    known = np.flatnonzero(np.isfinite(log_volume))
    if len(known) < FEWEST:
        return np.zeros(0, dtype=np.int64)
    order = known[np.argsort(-log_volume[known], kind="stable")]
    most = max(1, int(MOST * len(order)))
    gaps = -np.diff(log_volume[order[: most + 1]])
    wide = np.flatnonzero(gaps > np.log(FACTOR))
    return order[: wide[-1] + 1] if len(wide) else order[:0]
