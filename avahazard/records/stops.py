"""Stops known as points on the map, put on the line of their path."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.records.path import Profile
from avahazard.records.rows import EventRow

FARTHEST_M = 200.0
"""A stop farther from the line of its path belongs to another path, or is in another system."""
AS_NEAR_M = 10.0
"""Two places on the line whose distances to the stop differ by less cannot be told apart."""


Convert = Callable[[Floats, str, str], Floats]
"""A point `[2]` moved from one reference system to another; nan where it has no place there."""


class PlacedStop(NamedTuple):
    """Its distance along the path and from the line (m); what would be accepted, or empty."""

    x_m: float
    distance_m: float
    accepted: str


def place_stop(row: EventRow, profile: Profile, convert: Convert | None) -> PlacedStop:
    """The place on the line of `profile` nearest to the coordinates of `row`.

    Without `convert`, coordinates in another system than those of the line are not accepted.
    """
    line = _line(profile)
    if line is None:
        return PlacedStop(0.0, 0.0, "runout_x_m: the profile of the path has no coordinates")
    xy, system = line
    if row.lon is None and row.crs is None:
        return PlacedStop(0.0, 0.0, "a crs beside easting_m and northing_m")
    place = (row.lon, row.lat) if row.lon is not None else (row.easting_m, row.northing_m)
    given = "EPSG:4326" if row.lon is not None else str(row.crs)
    point = np.array(place, np.float64)
    if given != system:
        point = np.full(2, np.nan) if convert is None else convert(point, given, system)
    if not np.all(np.isfinite(point)):
        return PlacedStop(0.0, 0.0, f"coordinates that exist in {system}")
    if system == "EPSG:4326":  # degrees as metres near the stop
        metres = 111_195.0 * np.array([np.cos(np.radians(point[1])), 1.0])
        xy, point = (xy - point) * metres, np.zeros(2)
    step = np.diff(xy, axis=0)
    share = np.einsum("ij,ij->i", point - xy[:-1], step) / np.einsum("ij,ij->i", step, step)
    inside = np.clip(share, 0.0, 1.0)
    distance = np.hypot(*(xy[:-1] + inside[:, None] * step - point).T)
    x = profile.x_m[:-1] + inside * np.diff(profile.x_m)
    k = int(np.argmin(distance))
    accepted = ""
    beyond = (share[k] - 1.0) * float(np.hypot(*step[k])) if k == len(step) - 1 else 0.0
    near = np.flatnonzero(distance <= distance[k] + AS_NEAR_M)
    gaps = np.flatnonzero(np.diff(near) > 1)
    if distance[k] > FARTHEST_M:
        accepted = f"a point within {FARTHEST_M:g} m of the path's line: it is {distance[k]:.0f} m"
    elif beyond > AS_NEAR_M:
        accepted = (
            f"a point on the path: it is {beyond:.0f} m past the end of its line; draw the line "
            "longer, or left_profile 1"
        )
    elif len(gaps):
        one, other = x[near[gaps[0]]], x[near[gaps[0] + 1]]
        accepted = f"runout_x_m: the line passes twice, at {one:.0f} and {other:.0f} m"
    return PlacedStop(float(x[k]), float(distance[k]), accepted)


def _line(profile: Profile) -> tuple[Floats, str] | None:
    if profile.lon is not None and profile.lat is not None:
        return np.column_stack([profile.lon, profile.lat]), "EPSG:4326"
    if profile.easting_m is None or profile.northing_m is None or profile.crs is None:
        return None
    return np.column_stack([profile.easting_m, profile.northing_m]), profile.crs
