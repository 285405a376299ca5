"""Which offsets of log friction a model has: those of all its groups of events, in one row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Effect, GroupEffect, of_kind

Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class OffsetPlan:
    """Groupings by the effects `keys`, crossed or nested as they come, and their offsets.

    `index` `[n_groupings, n_events]` is the place of an event's offset in the row of all, -1 for
    none; `alone` `[n_groupings, n_events]`: it has one of its own, which adds to its scatter.
    `of` `[n_offsets]` is the grouping of each, `names` and `told` `[n_offsets]` what it is called
    in the store and by people. `lasting` `[n_groupings]`: what is to come has the same groups.
    """

    keys: tuple[str, ...]
    names: tuple[str, ...]
    told: tuple[str, ...]
    of: Indices
    index: Indices
    alone: NDArray[np.bool_]
    lasting: tuple[bool, ...]

    def __bool__(self) -> bool:
        return len(self.keys) > 0

    @property
    def rest(self) -> Indices:
        """Place of each offset `[n_offsets]` among those that are not of the largest grouping.

        -1 for those that are: given the others, they know nothing of each other.
        """
        counts = np.bincount(self.of, minlength=max(len(self.keys), 1))
        others = self.of != np.argmax(counts)
        return np.where(others, np.cumsum(others) - 1, -1)

    @property
    def n_crossed(self) -> int:
        """Number of offsets that are not of the largest grouping."""
        return int(np.sum(self.rest >= 0))

    def shift(self, offsets: Floats) -> Floats:
        """Sum of the offsets `[n_offsets]` that each event has, `[n_events]`."""
        row = np.append(offsets, 0.0)
        return np.asarray(row[self.index].sum(axis=0), dtype=np.float64)

    def without(self, keys: Sequence[str]) -> OffsetPlan:
        """The plan less the groupings by these effects."""
        kept = [g for g, key in enumerate(self.keys) if key not in keys]
        taken = np.isin(self.of, kept)
        moved = np.append(np.where(taken, np.cumsum(taken) - 1, -1), -1)
        return OffsetPlan(
            tuple(self.keys[g] for g in kept),
            tuple(name for name, t in zip(self.names, taken, strict=True) if t),
            tuple(name for name, t in zip(self.told, taken, strict=True) if t),
            np.searchsorted(kept, self.of[taken]).astype(np.int64),
            moved[self.index[kept]],
            self.alone[kept],
            tuple(self.lasting[g] for g in kept),
        )


def offset_plan(effects: Sequence[Effect], columns: EventColumns) -> OffsetPlan:
    """The groupings of a model's effects on these events."""
    keys: list[str] = []
    names: list[str] = []
    told: list[str] = []
    of: list[int] = []
    lasting: list[bool] = []
    index = np.empty((0, len(columns)), dtype=np.int64)
    alone = np.empty((0, len(columns)), dtype=np.bool_)
    for effect in of_kind(effects, GroupEffect):
        groups = effect.groups(columns)
        index = np.vstack([index, np.where(groups.index >= 0, groups.index + len(names), -1)])
        alone = np.vstack([alone, groups.alone & (groups.index < 0)])
        of += [len(keys)] * len(groups.names)
        names += groups.names
        told += [f"{groups.told}{name}" for name in groups.names]
        lasting.append(not groups.alone)
        keys.append(effect.key)
    return OffsetPlan(
        tuple(keys),
        tuple(names),
        tuple(told),
        np.array(of, dtype=np.int64),
        index,
        alone,
        tuple(lasting),
    )
