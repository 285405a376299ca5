"""The volumes' stated errors are too small or too large."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, VolumeErrorEffect
from avahazard.effects.error_factor import MOST, factor, log_factor
from avahazard.effects.needs import MIN_LEVEL
from avahazard.effects.site import Site
from avahazard.effects.volume_spread import largest_factor


def _lacking(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    known = np.isfinite(columns.log_volume)
    if int(np.sum(known)) < 4 * MIN_LEVEL or np.ptp(columns.log_volume[known]) == 0.0:
        return f"fewer than {4 * MIN_LEVEL} events have (different) volumes"
    if not np.any(columns.volume_error[known] > 0.0):
        return "the volumes are stated to be exact"
    return None


def _facts(columns: EventColumns, _sites: Sequence[Site]) -> Facts:
    # Errors cannot scatter the recorded volumes more than these do.
    return {"highest": float(np.clip(np.log(max(largest_factor(columns), 1e-9)), 0.0, MOST))}


def _build(facts: Facts) -> VolumeErrorEffect:
    return VolumeErrorEffect("volume-error", (log_factor(facts["highest"]),), scale=factor)


DEFINITION = Definition(
    key="volume-error",
    meaning="The stated errors of the volumes are too small or too large, all by one factor. "
    "Friction then scatters most where the law is steepest in volume, and bends towards its mean.",
    needs=f"{4 * MIN_LEVEL} events with volumes and errors of these",
    build=_build,
    lacking=_lacking,
    facts=_facts,
    order=166,
)
