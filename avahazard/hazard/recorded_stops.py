"""The recorded stops of a path, and where its places are on the map."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.site import stop_places
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.records.collection import Records
from avahazard.records.lookup import of_path
from avahazard.records.path import Profile
from avahazard.results.hazard import FarthestRecord, MapPoint

DEGREES = "EPSG:4326"


@dataclass(frozen=True, slots=True, eq=False)
class RecordedStops:
    """Recorded stops `x` (m) `[n_records]` with their dates, inf for what left the profile.

    The path's line is `east`, `north` at `line_x` (m), all `[n_points]`, in the system `crs`;
    empty where the profile has no coordinates.
    """

    x: Floats = field(default_factory=lambda: np.empty(0))
    dates: tuple[str | None, ...] = ()
    line_x: Floats = field(default_factory=lambda: np.empty(0))
    east: Floats = field(default_factory=lambda: np.empty(0))
    north: Floats = field(default_factory=lambda: np.empty(0))
    crs: str = ""

    def farthest(self) -> FarthestRecord | None:
        """The stop farthest down, the latest of equals; None without records."""
        if not len(self.x):
            return None
        k = max(range(len(self.x)), key=lambda i: (self.x[i], self.dates[i] or ""))
        place = float(self.x[k])
        return FarthestRecord(place if np.isfinite(place) else None, self.dates[k])

    def beyond(self, x: float) -> int:
        """How many of them lie past a place x (m) on the profile."""
        return int(np.count_nonzero(self.x > x))

    def point(self, x: float) -> MapPoint | None:
        """The place x (m) on the map; None without coordinates, or off their line."""
        if not len(self.line_x) or not self.line_x[0] <= x <= self.line_x[-1]:
            return None
        east, north = (float(np.interp(x, self.line_x, c)) for c in (self.east, self.north))
        return MapPoint(east, north, self.crs)


def recorded_stops_of(records: Records, path_id: str, smooth: SmoothProfile) -> RecordedStops:
    """What is recorded on a path whose regularised profile is `smooth`."""
    mine = of_path(records, path_id)
    places = stop_places(smooth, mine.events)
    (profile,) = mine.profiles
    return RecordedStops(
        np.array([np.inf if x is None else x for x in places], np.float64),
        tuple(event.date for event in mine.events),
        *_line(profile),
    )


def _line(profile: Profile) -> tuple[Floats, Floats, Floats, str]:
    """The line of a profile on the map; coordinates in metres mean nothing without a system."""
    if profile.easting_m is not None and profile.northing_m is not None and profile.crs:
        return profile.x_m, profile.easting_m, profile.northing_m, profile.crs
    if profile.lon is not None and profile.lat is not None:
        return profile.x_m, profile.lon, profile.lat, DEGREES
    return np.empty(0), np.empty(0), np.empty(0), ""
