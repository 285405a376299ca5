"""The stated errors of the records, or of the volumes, are too small or too large."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import (
    MIN_LEVEL,
    Definition,
    Facts,
    Parameter,
    RecordErrorEffect,
    Sites,
    VolumeErrorEffect,
)

PRIOR_SD = float(np.log(2.0))
"""Errors are stated by judgement; that they are off by two either way is common, by four rare."""
MOST = float(np.log(8.0))
MIN_SPREAD = 0.1
"""Smallest natural spread of log volume that is believed."""


def _log_factor(high: float = MOST) -> tuple[Parameter, ...]:
    """The log of the factor, none of it (0) being what is stated."""
    return (Parameter("log_factor", "log of the factor", 0.0, 0.0, PRIOR_SD, -MOST, high),)


def _factor(values: Floats) -> float:
    """The factor at values `[1]` of its log; 1 to the last bit at 0."""
    return float(np.exp(values[0]))


def _few_records(columns: EventColumns, _sites: Sites) -> str | None:
    return None if len(columns) >= 4 * MIN_LEVEL else f"fewer than {4 * MIN_LEVEL} events"


RECORD_ERROR = Definition(
    key="record-error",
    meaning="The stated errors of the records are too small or too large, all by one factor. "
    "Such an error moves the friction that a record asks for more on some ground than on other, "
    "natural scatter does so alike, which tells them apart.",
    needs=f"{4 * MIN_LEVEL} events",
    build=lambda _: RecordErrorEffect("record-error", _log_factor(), _factor),
    lacking=_few_records,
    order=164,
)


def variance_within(groups: Sequence[Floats]) -> float:
    """Variance of values about the mean of their group, one degree of freedom a group."""
    groups = [values for values in groups if len(values)]
    squares = sum(float(np.sum((values - np.mean(values)) ** 2)) for values in groups)
    return squares / max(1, sum(len(values) for values in groups) - len(groups))


def largest_factor(columns: EventColumns) -> float:
    """The factor on the stated errors of volumes at which these explain all that volumes scatter.

    inf where no error is stated.
    """
    known = np.isfinite(columns.log_volume)
    stated2 = float(np.mean(columns.volume_error[known] ** 2)) if np.any(known) else 0.0
    if stated2 == 0.0:
        return np.inf
    members = [known & (columns.path_index == k) for k in range(-1, len(columns.paths))]
    total2 = variance_within([columns.log_volume[mine] for mine in members])
    return float(np.sqrt(max(total2 - MIN_SPREAD**2, 0.0) / stated2))


def _few_volumes(columns: EventColumns, _sites: Sites) -> str | None:
    known = np.isfinite(columns.log_volume)
    if int(np.sum(known)) < 4 * MIN_LEVEL or np.ptp(columns.log_volume[known]) == 0.0:
        return f"fewer than {4 * MIN_LEVEL} events have (different) volumes"
    if not np.any(columns.volume_error[known] > 0.0):
        return "the volumes are stated to be exact"
    return None


def _highest(columns: EventColumns, _sites: Sites) -> Facts:
    # Errors cannot scatter the recorded volumes more than these do.
    return {"highest": float(np.clip(np.log(max(largest_factor(columns), 1e-9)), 0.0, MOST))}


VOLUME_ERROR = Definition(
    key="volume-error",
    meaning="The stated errors of the volumes are too small or too large, all by one factor. "
    "Friction then scatters most where the law is steepest in volume, and bends towards its mean.",
    needs=f"{4 * MIN_LEVEL} events with volumes and errors of these",
    build=lambda facts: VolumeErrorEffect("volume-error", _log_factor(facts["highest"]), _factor),
    lacking=_few_volumes,
    facts=_highest,
    order=166,
)
