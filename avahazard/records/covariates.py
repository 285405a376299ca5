"""Columns beyond those of docs/data_forms.md: kept as numbers or as words."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Literal

from avahazard.records.errors import RowProblem
from avahazard.records.forms.meanings import MEANINGS
from avahazard.records.path import Covariate
from avahazard.records.table import Table

Kind = Literal["number", "text"]
NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
LARGEST = 1e30  # its square must still be a number
NOT_FINITE = re.compile(r"[+-]?(?:inf|infinity|nan)", re.IGNORECASE)


def column_kinds(rows: Iterable[Mapping[str, Covariate]]) -> dict[str, Kind]:
    """Return how each covariate of stored records is held."""
    kinds: dict[str, Kind] = {}
    for row in rows:
        for name, value in row.items():
            kinds.setdefault(name, "text" if isinstance(value, str) else "number")
    return kinds


def read_covariates(
    tables: Sequence[Table],
    own_columns: set[str],
    stored: Mapping[str, Kind],
    problems: list[RowProblem],
    notes: list[str],
) -> dict[tuple[str, int], dict[str, Covariate]]:
    """Return the covariates of every row of `tables`, keyed (file, line).

    A column is one of numbers where its meaning says so or most of its values are numbers,
    unless the records stored before hold it as text; empty cells are left out. Texts in a
    column of numbers, and numbers that are not finite or out of bounds, are added to
    `problems`. Numbers in a column of words are words, which is added to `notes`.
    """
    names = dict.fromkeys(c for t in tables for c in t.header if c not in own_columns)
    kinds = {name: stored.get(name) or _kind(tables, name) for name in names}
    notes += [
        note for name, kind in kinds.items() if kind == "text" for note in _mixed(tables, name)
    ]
    found: dict[tuple[str, int], dict[str, Covariate]] = {}
    for table in tables:
        extra = [name for name in table.header if name in kinds]
        for line, cells in table.numbered(extra):
            values: dict[str, Covariate] = {}
            for name, text in cells.items():
                if kinds[name] == "text":
                    values[name] = text
                elif NUMBER.fullmatch(text) and abs(float(text)) <= LARGEST:
                    values[name] = float(text)
                else:
                    problems.append(
                        RowProblem(table.file, line, name, text, _accepted(name, stored))
                    )
            found[table.file, line] = values
    return found


def _kind(tables: Sequence[Table], name: str) -> Kind:
    """A column of numbers and a few words is one of numbers with mistakes, not one of words."""
    if _means_numbers(name):
        return "number"
    found = sum((table.counts(name) for table in tables), Counter[str]())
    numbers = sum(n for text, n in found.items() if _like_a_number(text))
    return "number" if 2 * numbers > found.total() else "text"


def _mixed(tables: Sequence[Table], name: str) -> Iterator[str]:
    """Say of each file that a column of words holds numbers as well."""
    for table in tables:
        numbers = {text: _like_a_number(text) for text in table.counts(name)}
        if len(set(numbers.values())) == 2:
            word_k, word = next(cell for cell in table.values(name) if not numbers[cell[1]])
            k, number = next(cell for cell in table.values(name) if numbers[cell[1]])
            yield (
                f"{table.file}: {name} is read as words: line {table.lines[word_k]} holds "
                f"{word!r}, line {table.lines[k]} {number}."
            )


def _like_a_number(text: str) -> bool:
    return bool(NUMBER.fullmatch(text) or NOT_FINITE.fullmatch(text))


def _means_numbers(name: str) -> bool:
    return name in MEANINGS and MEANINGS[name].content == "number" and bool(MEANINGS[name].further)


def _accepted(name: str, stored: Mapping[str, Kind]) -> str:
    finite = f"a number of at most {LARGEST:g} in size"
    if name in stored:
        return f"{finite}: the records stored before hold {name} as numbers"
    if _means_numbers(name):
        return f"{finite}, or an empty cell where it is missing"
    return f"{finite}, as most of the column, or an empty cell where it is missing"
