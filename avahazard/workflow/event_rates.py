"""How often avalanches of which volume come, for the paths that a command works on."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from avahazard.hazard.event_volumes import EventVolumes, one_volume
from avahazard.hazard.volume_frequency import N_DRAWS
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import find_path, find_profile
from avahazard.workflow.frequencies import Frequencies
from avahazard.workflow.future_events import ignores_volume
from avahazard.workflow.stored.model import StoredFit

ANY_VOLUME_M3 = 1e4
"""Stands for the volume where it does not matter."""


def volumes_by_path(
    stored: StoredFit, frequencies: Frequencies, paths: Sequence[str]
) -> tuple[dict[str, EventVolumes], list[str]]:
    """Rate and volumes by path, and why paths that nobody named are left out.

    Raises:
        AvahazardError: a path of `paths` has no profile or no rate, or none of all paths has.
    """
    records = stored.records
    for path_id in paths:
        find_profile(records, find_path(records, path_id))
    profiles = {profile.path_id for profile in records.profiles}
    named = sorted(set(paths) or {p.path_id for p in records.paths} & profiles)
    if not named:
        raise AvahazardError(
            "There are no paths with a profile.", "Import paths.csv and profiles.csv first."
        )
    found, notes, refusals = {}, [], []
    for path_id in named:
        try:
            found[path_id] = _of_path(stored, frequencies, path_id)
        except AvahazardError as error:
            if paths:
                raise
            refusals.append(error)
            notes.append(f"left out: {error.message}")
    if not found:
        raise refusals[0]
    return found, notes


def _of_path(stored: StoredFit, frequencies: Frequencies, path_id: str) -> EventVolumes:
    rate = frequencies.rate_of(path_id, N_DRAWS) if ignores_volume(stored) else None
    if rate is None:
        return frequencies.of(path_id).volumes()
    any_volume = one_volume(ANY_VOLUME_M3, N_DRAWS)
    return EventVolumes(rate, any_volume.log_volume, any_volume.share)


def extrapolation(frequencies: Frequencies, path_id: str) -> Callable[[float], bool]:
    """A function that tells whether a return period (years) is too long for the path's record."""
    try:
        return frequencies.of(path_id).extrapolated
    except AvahazardError:
        # A rate alone, for a model without volumes.
        record = frequencies.region.records[path_id]
        return lambda period: period > 2 * record.n_years
