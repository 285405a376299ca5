"""How recorded volumes scatter, and how much of that can be error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns

MIN_SPREAD = 0.1
"""Smallest natural spread of log volume that is believed."""


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
