"""How the columns of the files were understood, for people to look at before they import."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from itertools import islice

from avahazard.records.covariates import NUMBER
from avahazard.records.forms.meanings import MEANINGS
from avahazard.records.table import Table

FIRST_VALUES = 3


@dataclass(frozen=True, slots=True)
class UnderstoodColumn:
    """A column of a file: its name there, what it means, its unit, its first values as read."""

    file: str
    form: str
    column: str
    meaning: str
    unit: str
    values: tuple[str, ...]


def understood(table: Table, form: str, columns: Collection[str]) -> list[UnderstoodColumn]:
    """Say it for every column of `table`; `columns` are those of its form."""
    found = []
    for name in table.header:
        first = tuple(text for _, text in islice(table.values(name), FIRST_VALUES))
        if name in columns and name in MEANINGS:
            words, unit = MEANINGS[name].words, MEANINGS[name].unit
            meaning = f"{name}: {words}" if name in table.spelt else words
        else:
            unit = ""
            numbers = first and all(NUMBER.fullmatch(text) for _, text in table.values(name))
            kind = "numbers" if numbers else "words"
            kept = form in ("paths", "events")
            meaning = f"your own column, {kind}" if kept else "not used"
        spelt = table.spelt.get(name, name)
        found.append(UnderstoodColumn(table.file, form, spelt, meaning, unit, first))
    return found


def summary(table: Table, form: str) -> str:
    """One line for a file or sheet: what it holds, and how it was read."""
    n = len(table.lines)
    rows = "1 row" if n == 1 else f"{n} rows"
    return f"{table.file}: {form}, {rows} ({', '.join(table.words)})"
