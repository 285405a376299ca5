"""Candidates spelled out, their tables held as far as there is room for them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from avahazard.criticism.screening.alternatives import Alternative, Spelled
from avahazard.criticism.screening.tables import Tables

MOST_BYTES = 256_000_000
"""Memory of tables that are kept from one look at the candidates to the next."""


class HeldAlternatives:
    """Alternatives value by value of each candidate, in the same order at each look.

    Those with tables of their own are some 100 tables of 3 kB for each event: what finds no room
    is made anew at each look, and dropped before the next one.
    """

    def __init__(
        self, spelled: Sequence[Spelled], base: Tables, most_bytes: int = MOST_BYTES
    ) -> None:
        self._spelled = spelled
        self._base = base
        self._room = most_bytes
        self._held: dict[int, list[Alternative]] = {}

    def __len__(self) -> int:
        return len(self._spelled)

    def __iter__(self) -> Iterator[list[Alternative]]:
        for k, spell in enumerate(self._spelled):
            yield self._held[k] if k in self._held else self._kept(k, spell())

    @property
    def all_held(self) -> bool:
        """Whether another look costs no tables; known after the first."""
        return len(self._held) == len(self._spelled)

    def _kept(self, k: int, made: list[Alternative]) -> list[Alternative]:
        own = {id(a.tables.record): a.tables for a in made if a.tables is not self._base}
        size = sum(map(_bytes, own.values()))
        if size <= self._room:
            self._room -= size
            self._held[k] = made
        return made


def _bytes(tables: Tables) -> int:
    """Memory of what a set of tables has of every event."""
    parts = (*tables.edges, *tables.speeds, tables.record, tables.bounds, tables.last_left)
    return sum(part.nbytes for part in parts if isinstance(part, np.ndarray))
