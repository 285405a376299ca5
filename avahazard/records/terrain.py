"""Whether a recorded place can be found on its profile."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.event import Event, Speed
from avahazard.records.path import Path, Profile

Fault = tuple[str, float, str]  # column, value, what would be accepted

# So many standard deviations of the ground must a path rise before two places count.
RISE_SD = 3.0

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
        low, high, *_ = _heights(profile)
        if not low - slack <= elevation <= high + slack:
            accepted = f"{low:g} to {high:g} (the profile), or left_profile 1"
            return "runout_elevation_m", elevation, accepted
    return None


def release_fault(record: Event | Path, profile: Profile) -> Fault | None:
    """Return what is wrong with the release elevation of an event or a path."""
    release = record.release_elevation_m
    if release is None:
        return None
    low, high, *_ = _heights(profile)
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
        low, high, *_ = _heights(profile)
        if not low - MAP_TOLERANCE_M <= speed.elevation_m <= high + MAP_TOLERANCE_M:
            return "elevation_m", speed.elevation_m, f"{low:g} to {high:g} (the profile)"
    return None


def on_counter_slope(elevation_m: float, profile: Profile) -> bool:
    """Tell whether the profile reaches `elevation_m` on both sides of its lowest point.

    Points that rise by no more than their error make no counter-slope.
    """
    lowest, _, beyond = _heights(profile)
    return lowest < elevation_m <= beyond and _rises(profile)


@lru_cache(maxsize=KEPT)
def _heights(profile: Profile) -> tuple[float, float, float]:
    """The lowest and the highest point, and the highest beyond the lowest (m)."""
    lowest = int(np.argmin(profile.y_m))
    y = profile.y_m
    return float(y[lowest]), float(y.max()), float(y[lowest:].max())


@lru_cache(maxsize=KEPT)
def _rises(profile: Profile) -> bool:
    """Whether the ground rises beyond its lowest place by more than its error allows."""
    smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    height = smooth.height(profile.x_m)
    sd = np.zeros(len(height))
    if smooth.posterior is not None:
        sd = smooth.posterior.sd(profile.x_m)
    lowest = int(np.argmin(height))
    rise = height[lowest:] - height[lowest]
    return bool(np.any(rise > RISE_SD * np.hypot(sd[lowest:], sd[lowest])))
