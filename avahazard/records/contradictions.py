"""Values of one event that cannot all be true."""

from __future__ import annotations

import math

import numpy as np

from avahazard.message import message
from avahazard.records import defaults
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from avahazard.records.terrain import MAP_TOLERANCE_M, Fault, on_counter_slope

N_SIGMA = 3.0
# Two measurements of one volume differ by this factor at least before one of them is wrong.
VOLUME_FACTOR = 2.0
OF_DEPOSIT = message("about {deposit}, half of length times width times thickness; or one of both")
AT_THAT_PLACE = message("about {there}, where the profile is at runout_x_m {x}; or one of both")
NOT_LEFT = message("left_profile 0, or a runout at the end of the profile or beyond, or none")
BELOW = message("a stop below the release, which is at {release} ({whose})")
OF_PATH = message("release_elevation_m of the path")


def volume_fault(event: Event) -> Fault | None:
    """Return what is wrong where the volume is not that of its deposit, V = L W H / 2."""
    sides = (event.deposit_length_m, event.deposit_width_m, event.deposit_thickness_m)
    known = [side for side in sides if side is not None]
    if event.volume_m3 is None or len(known) < 3:
        return None
    deposit = defaults.deposit_volume_m3(*known)
    allowed = max(math.log(VOLUME_FACTOR), N_SIGMA * event.volume_rel_sigma)
    if abs(math.log(event.volume_m3) - math.log(deposit)) > allowed:
        return "volume_m3", event.volume_m3, OF_DEPOSIT.format(deposit=f"{deposit:g}")
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
            there = f"{np.interp(x, profile.x_m, profile.y_m):g}"
            return "runout_elevation_m", elevation, AT_THAT_PLACE.format(there=there, x=f"{x:g}")
    return _above_the_release(event, path, profile, slack)


def unseen_elevation(event: Event, path: Path, profile: Profile | None) -> float | None:
    """Elevation (m) of a stop over the limit of sight of its path by more than its error; or None.

    What goes on beyond such a limit, up the other side of a valley too, is seen.
    """
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
    end = float(profile.x_m[-1])
    if event.runout_x_m is not None:
        before = event.runout_x_m < end - slack
        return ("runout_x_m", event.runout_x_m, NOT_LEFT) if before else None
    elevation = event.runout_elevation_m
    if elevation is None or on_counter_slope(elevation, profile):
        return None
    if elevation > float(profile.y_m[-1]) + slack + MAP_TOLERANCE_M:
        return "runout_elevation_m", elevation, NOT_LEFT
    return None


def _above_the_release(
    event: Event, path: Path | None, profile: Profile, slack: float
) -> Fault | None:
    """A release is the event's own, else the path's; the top of the profile is above every stop."""
    own = event.release_elevation_m is not None
    release = event.release_elevation_m
    if path is not None and release is None:
        release = path.release_elevation_m
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
    whose = "release_elevation_m" if own else OF_PATH
    return column, value, BELOW.format(release=f"{release:g}", whose=whose)


def _elevations(profile: Profile, first: float, last: float) -> tuple[float, float]:
    """The lowest and highest elevation of the profile from `first` to `last`."""
    inside = (profile.x_m > first) & (profile.x_m < last)
    ends = np.interp([first, last], profile.x_m, profile.y_m)
    every = np.concatenate([profile.y_m[inside], ends])
    return float(every.min()), float(every.max())
