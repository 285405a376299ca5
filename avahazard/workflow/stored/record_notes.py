"""What whoever reads a model must know of the records that it was calibrated on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.effects.site import Site
from avahazard.message import message
from avahazard.records.collection import Records
from avahazard.records.contradictions import place_fault, volume_fault

MISFIT_M = 10.0
"""Deviation of the regularised path from its points from which a reader is told."""
MISFIT_SIGMAS = 4.0
"""… where it is also that many times their error: the farthest of hundreds lies some 3 away."""
SHOWN = 3
MISSES = message(
    "the path that the block runs on misses the points of its profile: {paths}. Look at it: "
    "avahazard path PATH --plot FILE."
)
CONTRADICT = message("records contradict themselves: {events}.")
MORE = message("{n} more")


def record_notes(records: Records, sites: Sequence[Site]) -> tuple[str, ...]:
    """Paths that miss their terrain, and events whose values cannot all be true.

    An import refuses the latter; a database of an earlier version may hold them.
    """
    return (*_misfits(records, sites), *_contradictions(records))


def _misfits(records: Records, sites: Sequence[Site]) -> list[str]:
    profiles = {profile.path_id: profile for profile in records.profiles}
    found = []
    for site in {site.path.path_id: site for site in sites}.values():
        profile, smooth = profiles.get(site.path.path_id), site.smooth
        if profile is None:  # a straight line has no points to miss
            continue
        away = np.abs(smooth.height(profile.x_m) - profile.y_m)
        farthest = int(np.argmax(away))
        if away[farthest] > max(MISFIT_M, MISFIT_SIGMAS * smooth.sigma_m):
            place = f"{away[farthest]:.0f} m at x = {profile.x_m[farthest]:.0f} m"
            found.append(f"{site.path.path_id} ({place})")
    if not found:
        return []
    return [MISSES.format(paths=_listed(found))]


def _contradictions(records: Records) -> list[str]:
    profiles = {profile.path_id: profile for profile in records.profiles}
    paths = {path.path_id: path for path in records.paths}
    found = []
    for event in records.events:
        fault = volume_fault(event)
        profile = profiles.get(event.path_id or "")
        if fault is None and profile is not None:
            fault = place_fault(event, paths.get(profile.path_id), profile)
        if fault is not None:
            column, value, accepted = fault
            found.append(f"{event.event_id} ({column} {value:g}; accepted would be {accepted})")
    if not found:
        return []
    return [CONTRADICT.format(events=_listed(found))]


def _listed(found: Sequence[str]) -> str:
    more = f" and {MORE.format(n=len(found) - SHOWN)}" if len(found) > SHOWN else ""
    return f"{', '.join(found[:SHOWN])}{more}"
