"""Stops whose error is as large as their path is high: they tell nothing of friction."""

from __future__ import annotations

import numpy as np

from avahazard.records.collection import Records

SHOWN = 3


def vague_stops(new: Records, stored: Records) -> list[str]:
    """A note on the new events whose error reaches the drop of their path's profile, if any."""
    profiles = {p.path_id: p for p in (*stored.profiles, *new.profiles)}
    drops = {key: float(np.max(p.y_m) - np.min(p.y_m)) for key, p in profiles.items()}
    found = [
        f"{e.event_id}: {e.runout_sigma_m:g} m, {e.path_id} drops {drops[e.path_id]:.0f} m"
        for e in new.events
        if e.path_id in drops and not e.left_profile and e.runout_sigma_m >= drops[e.path_id]
    ]
    if not found:
        return []
    more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return [
        f"runout_sigma_m is not below the drop of the path ({'; '.join(found[:SHOWN])}{more}): "
        "such a stop tells nothing of friction. Is its unit m?"
    ]
