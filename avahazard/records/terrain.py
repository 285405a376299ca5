"""Whether a recorded place can be found on its profile."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.event import Event, Speed
from avahazard.records.path import Path, Profile

Fault = tuple[str, float, str]  # column, value, what would be accepted
Rises = tuple[tuple[float, float], ...]

# So many standard deviations of the ground must a path rise before two places count; and amid the
# path by as much as no stop is known better.
RISE_SD = 3.0
LEAST_RISE_M = 10.0

# Elevations read from another map than the profile differ by about this much.
MAP_TOLERANCE_M = 30.0

# Profiles that are looked at once: events come in any order of a region's paths.
KEPT = 20_000


def stop_fault(event: Event, profile: Profile) -> Fault | None:
    """Return what is wrong with the stop of `event`, None when it is one place on `profile`.

    Outside the profile is accepted within three standard deviations of the record, and
    for events that left it.
    """
    if event.left_profile:
        return None
    slack = 3.0 * event.runout_sigma_m
    if event.runout_x_m is not None:
        first, last = float(profile.x_m[0]), float(profile.x_m[-1])
        if not first - slack <= event.runout_x_m <= last + slack:
            accepted = f"{first:g} to {last:g} (the profile), or left_profile 1"
            return "runout_x_m", event.runout_x_m, accepted
    elif event.runout_elevation_m is not None:
        elevation = event.runout_elevation_m
        if on_counter_slope(elevation, profile):
            return (
                "runout_elevation_m",
                elevation,
                "runout_x_m too: the profile rises again, and reaches this elevation at two places",
            )
        low, high = _heights(profile)
        if not low - slack <= elevation <= high + slack:
            accepted = f"{low:g} to {high:g} (the profile), or left_profile 1"
            return "runout_elevation_m", elevation, accepted
    return None


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
        if stop is not None and stop > release + 3.0 * record.runout_sigma_m:
            return "release_elevation_m", release, f"an elevation above the runout at {stop:g}"
    return None


def speed_fault(speed: Speed, profile: Profile) -> Fault | None:
    """Return what is wrong with the place of `speed`."""
    if speed.x_m is not None:
        first, last = float(profile.x_m[0]), float(profile.x_m[-1])
        if not first <= speed.x_m <= last:
            return "x_m", speed.x_m, f"{first:g} to {last:g} (the profile)"
    elif speed.elevation_m is not None:
        if on_counter_slope(speed.elevation_m, profile):
            return (
                "elevation_m",
                speed.elevation_m,
                "x_m too: the profile rises again, and reaches this elevation at two places",
            )
        low, high = _heights(profile)
        if not low - MAP_TOLERANCE_M <= speed.elevation_m <= high + MAP_TOLERANCE_M:
            return "elevation_m", speed.elevation_m, f"{low:g} to {high:g} (the profile)"
    return None


def on_counter_slope(elevation_m: float, profile: Profile) -> bool:
    """Tell whether the profile reaches `elevation_m` again, on ground that rises.

    Points that rise by no more than their error make no counter-slope, nor do small steps amid the
    path.
    """
    # Most elevations lie on no rise of the points themselves, and most profiles have none.
    rises = _rises_of_points(profile)
    return bool(rises) and _among(elevation_m, rises) and _among(elevation_m, _rises(profile))


def _among(elevation_m: float, rises: Rises) -> bool:
    return any(low < elevation_m <= high for low, high in rises)


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
