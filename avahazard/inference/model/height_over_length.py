"""H/L of the recorded events: the slope of the line from release to stop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.site import Site
from avahazard.records.event import Event


def height_over_length(
    events: Sequence[Event], sites: tuple[Site, ...], release: NDArray[np.int64]
) -> Floats:
    """H/L of the line from release to recorded stop `[n_events]`; nan where the stop is unknown."""
    ratio = np.full(len(events), np.nan)
    of_path: dict[str, list[int]] = {}
    for i, e in enumerate(events):
        if e.path_id is not None:
            of_path.setdefault(e.path_id, []).append(i)
        elif e.fall_height_m and e.runout_length_m:
            ratio[i] = e.fall_height_m / e.runout_length_m
    for site in sites:
        x, y = site.terrain_x, site.heights()
        # Lowest so far, falling: its negative is sorted for the search.
        fallen = -np.minimum.accumulate(y)
        for i in of_path.get(site.path.path_id, ()):
            e = events[i]
            stop, start = e.runout_x_m, float(site.release_x[release[i]])
            if stop is None and e.runout_elevation_m is not None:
                place = int(np.searchsorted(fallen, -e.runout_elevation_m))
                stop = float(x[min(place, len(x) - 1)])
            if stop is not None and stop > start and not e.left_profile:
                top, bottom = np.interp([start, stop], x, y)
                ratio[i] = (top - bottom) / (stop - start)
    return ratio
