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
    ground: dict[str, tuple[Site, Floats, Floats]] = {}
    for site in sites:
        y = site.smooth.height(site.terrain.x)
        # Lowest so far, falling: its negative is sorted for the search.
        ground[site.path.path_id] = site, y, -np.minimum.accumulate(y)
    for i, e in enumerate(events):
        if e.path_id is None:
            if e.fall_height_m and e.runout_length_m:
                ratio[i] = e.fall_height_m / e.runout_length_m
            continue
        if e.path_id not in ground:
            continue
        site, y, fallen = ground[e.path_id]
        x, stop = site.terrain.x, e.runout_x_m
        if stop is None and e.runout_elevation_m is not None:
            stop = float(x[min(int(np.searchsorted(fallen, -e.runout_elevation_m)), len(x) - 1)])
        start = float(site.release_x[release[i]])
        if stop is not None and stop > start and not e.left_profile:
            top, bottom = np.interp([start, stop], x, y)
            ratio[i] = (top - bottom) / (stop - start)
    return ratio
