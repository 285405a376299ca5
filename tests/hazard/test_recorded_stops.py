"""The line of a path on the map."""

from __future__ import annotations

import numpy as np

from avahazard.hazard.path_hazard import RecordedStops
from avahazard.results.hazard import MapPoint


def test_the_map_holds_both_ends_of_the_line_and_nothing_beyond() -> None:
    line = {"line_x": [100.0, 900.0], "east": [7.0, 7.8], "north": [46.0, 46.4]}
    stops = RecordedStops(**{name: np.array(values) for name, values in line.items()}, crs="C")
    assert stops.point(100.0) == MapPoint(7.0, 46.0, "C")
    assert stops.point(900.0) == MapPoint(7.8, 46.4, "C")
    assert stops.point(np.nextafter(100.0, 0.0)) is None
    assert stops.point(np.nextafter(900.0, 1e4)) is None
    assert RecordedStops().point(0.0) is None


def test_without_records_or_coordinates_there_is_nothing() -> None:
    nothing = RecordedStops()
    assert {len(c) for c in (nothing.x, nothing.line_x, nothing.east, nothing.north)} == {0}
    assert nothing.farthest() is None
    assert nothing.point(0.0) is None
    assert nothing.beyond(0.0) == 0
