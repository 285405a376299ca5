"""Events in groups that share an offset of log friction: those of a path, a winter, a storm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]

MIN_SHARED = 5
"""Fewest groups of two events or more that tell their spread from the scatter of events."""


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Groups by name, and that of each event: `index` `[n_events]` into `names`, -1 for none.

    `alone`: an event without a group has an offset of its own, which adds to its scatter; what
    is to come is in none that is known. Otherwise groups last, as paths do. `told` comes before
    the name where people read it. Names must not meet those of other effects' groups.
    """

    names: tuple[str, ...]
    index: Indices
    alone: bool = False
    told: str = ""


def shared(labels: Sequence[str]) -> list[str]:
    """The labels that two events or more have, sorted; '' is none."""
    names, counts = np.unique([label for label in labels if label], return_counts=True)
    return [str(name) for name, count in zip(names, counts, strict=True) if count > 1]


def indices(labels: Sequence[str], names: Sequence[str]) -> Indices:
    """Place of each label among the names, -1 where it is not there."""
    place = {name: k for k, name in enumerate(names)}
    return np.array([place.get(label, -1) for label in labels], dtype=np.int64)
