"""What effects need of the data, and how a lack is told."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.effects.columns import EventColumns
from avahazard.effects.site import Site

MIN_LEVEL = 5
"""Fewest events of a level, or on each side of a split, that can speak for it."""


def needs_profile(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    """Profiles of the paths."""
    return None if np.any(columns.path_index >= 0) else "no event lies on a path with a profile"


def needs_volume(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    """Different volumes."""
    known = columns.log_volume[np.isfinite(columns.log_volume)]
    return None if len(known) and np.ptp(known) > 0 else "the events have no (different) volumes"


def level_counts(values: np.ndarray) -> dict[str, int]:
    """Number of events of each level, missing ones ('') left out."""
    levels, counts = np.unique(values[values != ""], return_counts=True)
    return {str(k): int(n) for k, n in zip(levels, counts, strict=True)}


def two_levels(name: str, values: np.ndarray) -> str | None:
    """At least two levels of a column, each on enough events."""
    enough = [k for k, n in level_counts(values).items() if n >= MIN_LEVEL]
    if len(enough) >= 2:
        return None
    return f"{name} has no two values with at least {MIN_LEVEL} events each"


def named(names: Sequence[str]) -> str:
    """Names in a row, as a sentence has them."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"
