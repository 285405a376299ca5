"""Measured speeds of the events as the likelihood has them: places along the path, in order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from avahazard.effects.site import Site, release_places, stop_place
from avahazard.inference.model.speed_record import SpeedRecord, speed_record
from avahazard.records.event import Event, Speed


def speed_records(
    speeds: Sequence[Speed],
    index: dict[str, int],
    events: Sequence[Event],
    sites: dict[str, Site],
    release: NDArray[np.int64],
) -> tuple[SpeedRecord, ...]:
    """Speeds by event, in the order of the events; elevations become the first place there."""
    of_event: dict[int, list[Speed]] = {}
    for speed in speeds:
        if speed.event_id in index:
            of_event.setdefault(index[speed.event_id], []).append(speed)
    result = []
    for i, measured in sorted(of_event.items()):
        path_id = events[i].path_id
        if path_id is None:
            continue
        site = sites[path_id]
        smooth = site.smooth
        stop = stop_place(smooth, events[i])
        places = release_places(smooth, [s.elevation_m for s in measured])
        x = [x if s.x_m is None else s.x_m for s, x in zip(measured, places, strict=True)]
        order = np.argsort(x, kind="stable")
        result.append(
            speed_record(
                event=i,
                x=np.array(x)[order],
                speed=np.array([s.speed_m_s for s in measured])[order],
                sigma=np.array([s.speed_sigma_m_s for s in measured])[order],
                release_x=float(site.release_x[release[i]]),
                stop_x=smooth.x_max if stop is None else min(stop, smooth.x_max),
            )
        )
    return tuple(result)
