"""Columns beyond those of docs/data_forms.md: kept as numbers or as words."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

from avahazard.records.errors import RowProblem
from avahazard.records.path import Covariate
from avahazard.records.table import Table

Kind = Literal["number", "text"]
NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
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
) -> dict[tuple[str, int], dict[str, Covariate]]:
    """Return the covariates of every row of `tables`, keyed (file, line).

    A column is one of numbers where every value in it is a number, unless the records
    stored before hold it as text; empty cells are left out. Texts in a column that is
    stored as numbers, and numbers that are not finite, are added to `problems`.
    """
    names = dict.fromkeys(c for t in tables for c in t.header if c not in own_columns)
    kinds = {name: stored.get(name) or _kind(tables, name) for name in names}
    found: dict[tuple[str, int], dict[str, Covariate]] = {}
    for table in tables:
        extra = [name for name in table.header if name in kinds]
        for line, cells in table.numbered():
            values: dict[str, Covariate] = {}
            for name in extra:
                text = cells.get(name)
                if text is None:
                    continue
                if kinds[name] == "text":
                    values[name] = text
                elif NUMBER.fullmatch(text) and math.isfinite(float(text)):
                    values[name] = float(text)
                else:
                    problems.append(
                        RowProblem(table.file, line, name, text, _accepted(name, stored))
                    )
            found[table.file, line] = values
    return found


def _kind(tables: Sequence[Table], name: str) -> Kind:
    """A column of numbers and a few nan is one of numbers with mistakes, not one of words."""
    texts = [cells[name] for table in tables for cells in table.rows if name in cells]
    like_numbers = all(NUMBER.fullmatch(t) or NOT_FINITE.fullmatch(t) for t in texts)
    return "number" if like_numbers and any(map(NUMBER.fullmatch, texts)) else "text"


def _accepted(name: str, stored: Mapping[str, Kind]) -> str:
    if name in stored:
        return f"a finite number: the records stored before hold {name} as numbers"
    return "a finite number, or an empty cell where it is missing"
