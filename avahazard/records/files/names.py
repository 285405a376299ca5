"""Names of columns that are known ones in another spelling, or nearly."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from functools import cache

from avahazard.records.forms.meanings import MEANINGS

UNITS = re.compile(r"_(?:m_s|m3|m2|m|ha)$")
SHORTEST_NEAR = 6  # letters: shorter words are too often one letter apart


def known_name(name: str) -> str | None:
    """Return the column that `name` spells in other cases, with blanks or a unit in brackets."""
    if name in MEANINGS:
        return name
    return _spelt().get(squash(name))


def near_name(name: str, columns: Iterable[str]) -> str | None:
    """Return the one of `columns` that `name` misses by a letter or by its unit, if any."""
    squashed = squash(name)
    for column in columns:
        without_unit = UNITS.sub("", column)
        if without_unit != column and squashed == squash(without_unit):
            return column
        if len(squashed) >= SHORTEST_NEAR and _one_letter_apart(squashed, squash(column)):
            return column
    return None


def squash(name: str) -> str:
    """Keep letters and digits alone, in lower case; m³ is m3."""
    folded = unicodedata.normalize("NFKC", name).casefold()
    return re.sub(r"[\W_]+", "", folded)


@cache
def _spelt() -> dict[str, str]:
    return {squash(column): column for column in MEANINGS}


def _one_letter_apart(one: str, other: str) -> bool:
    """A letter too many, too few, another one, or two neighbours swapped."""
    short, long = sorted((one, other), key=len)
    if len(long) - len(short) > 1 or one == other:
        return False
    i = next((k for k, (a, b) in enumerate(zip(short, long, strict=False)) if a != b), len(short))
    if len(short) < len(long):
        return short[i:] == long[i + 1 :]
    swapped = short[:i] + short[i : i + 2][::-1] + short[i + 2 :]
    return short[i + 1 :] == long[i + 1 :] or swapped == long
