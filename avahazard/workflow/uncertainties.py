"""Natural variability and uncertainty of the parameters, apart, and the runout exceeded in T."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, Protocol

import numpy as np

from avahazard.hazard.avalanches import Avalanches
from avahazard.hazard.event_volumes import EventVolumes, one_volume, with_volumes
from avahazard.hazard.exceedance import (
    Reach,
    RunoutSpread,
    at_volume,
    exceeded_runout,
    middle_runout,
    natural_runouts,
    reach,
    runout_spread,
)
from avahazard.hazard.volume_frequency import N_DRAWS, ReturnVolume, VolumeFrequency
from avahazard.workflow.frequencies import Frequencies
from avahazard.workflow.future_events import ignores_volume, path_avalanches
from avahazard.workflow.hazard_words import exceeded_words, natural_words, parameters_words
from avahazard.workflow.stored.model import StoredFit

ANY_VOLUME_M3 = 1e4
"""Stands for the volume where it does not matter."""


class WantedRow(Protocol):
    """A row to come, as `workflow.hazard` knows it."""

    @property
    def volume_m3(self) -> float | None:
        """The volume, None where it does not matter."""

    @property
    def return_period(self) -> float | None:
        """Years, None for a volume."""

    @property
    def returned(self) -> ReturnVolume | None:
        """The volume of the return period."""

    @property
    def frequency(self) -> VolumeFrequency | None:
        """The frequency of the path's volumes."""


def path_uncertainties(
    stored: StoredFit,
    path_id: str,
    wanted: Sequence[WantedRow],
    frequencies: Frequencies | None,
    seed: int,
) -> list[dict[str, Any]]:
    """For each of one path's rows what it has besides the bounds.

    `natural`: the runout of avalanches of the row's volume, all parameters at their middle.
    `parameters`: its median over the posterior of friction, and of the volume of the return
    period. `exceeded`: the runout that a year exceeds with chance 1/T, all volumes mixed at the
    path's rate. `reach`, in the first row: the annual chance of reaching places on the path.
    """
    volumes = _volumes(stored, path_id, wanted, frequencies)
    given = [w.volume_m3 for w in wanted if w.volume_m3 is not None]
    rate_known = volumes is not None
    volumes = volumes or one_volume(given[0] if given else ANY_VOLUME_M3, N_DRAWS)
    ready = path_avalanches(stored, path_id, with_volumes(volumes, np.log(given)), seed)
    rows = [_apart(stored, path_id, ready, row, rate_known) for row in wanted]
    if rate_known:
        rows[0]["reach"] = _reach(reach(ready))
    return rows


def _volumes(
    stored: StoredFit,
    path_id: str,
    wanted: Sequence[WantedRow],
    frequencies: Frequencies | None,
) -> EventVolumes | None:
    """Rate and volumes of the path; None where nothing is known, or no return period is asked."""
    for row in wanted:
        if row.frequency is not None:
            return row.frequency.volumes()
    if frequencies is None or not ignores_volume(stored):
        return None
    rate = frequencies.rate_of(path_id, N_DRAWS)
    return None if rate is None else EventVolumes(rate, *_anything(len(rate)))


def _anything(n: int) -> tuple[Any, Any]:
    volumes = one_volume(ANY_VOLUME_M3, n)
    return volumes.log_volume, volumes.share


def _apart(
    stored: StoredFit,
    path_id: str,
    ready: Avalanches,
    row: WantedRow,
    rate_known: bool,
) -> dict[str, Any]:
    period = row.return_period
    n = ready.n_parameters
    volume = np.full(n, np.log(row.volume_m3 or ANY_VOLUME_M3))
    fixed = at_volume(ready, volume)
    uncertain = fixed
    if row.frequency is not None and period is not None:
        uncertain = at_volume(ready, row.frequency.draws.log_volume(1.0 / period))
    result = {
        "natural": {
            **_lengths(runout_spread(ready, natural_runouts(fixed))),
            "interval": natural_words(stored, path_id),
        },
        "parameters": {
            **_lengths(runout_spread(ready, middle_runout(uncertain))),
            "interval": parameters_words(stored, path_id, return_period=period is not None),
        },
    }
    if rate_known and period is not None:
        result["exceeded"] = {
            **_lengths(runout_spread(ready, exceeded_runout(ready, period))),
            "interval": exceeded_words(stored, path_id),
        }
    return result


def _lengths(found: RunoutSpread) -> dict[str, Any]:
    return {"runout_x_m": asdict(found.x), "runout_elevation_m": asdict(found.elevation)}


def _reach(found: Reach) -> dict[str, Any]:
    low, middle, high = found.chance.T
    return {
        "x_m": found.x.tolist(),
        "elevation_m": found.elevation.tolist(),
        "p_per_year": {"q05": low.tolist(), "q50": middle.tolist(), "q95": high.tolist()},
    }
