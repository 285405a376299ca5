"""Columns under their known names, however they were spelt."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from avahazard.records.errors import RowProblem
from avahazard.records.files.names import known_name, near_name, squash
from avahazard.records.table import Table


def spell(table: Table, stored: Collection[str], problems: list[RowProblem]) -> Table:
    """Return `table` with known columns and `stored` covariates under their names, and say so.

    Two columns that mean one are added to `problems`.
    """
    own = {squash(name): name for name in stored}
    meant = {name: known_name(name) or own.get(squash(name), name) for name in table.header}
    for name, known in meant.items():
        if name != known and known in table.header:
            accepted = f"one column {known}: rename one of them or leave it out"
            problems.append(RowProblem(table.file, 1, name, name, accepted))
    changed = {name: known for name, known in meant.items() if name != known}
    twice = len(set(meant.values())) < len(meant)
    if twice and not any(known in table.header for known in changed.values()):
        accepted = "each column once, in one spelling"
        problems.append(RowProblem(table.file, 1, "", ", ".join(changed), accepted))
    if twice or not changed:
        return table
    said = ", ".join(f"{name} is {known}" for name, known in changed.items())
    return replace(
        table,
        header=tuple(meant.values()),
        columns={meant[name]: cells for name, cells in table.columns.items()},
        dated=frozenset((line, meant[name]) for line, name in table.dated),
        written=table.written and frozenset((line, meant[name]) for line, name in table.written),
        words=(*table.words, f"columns: {said}"),
        spelt={known: name for name, known in changed.items()},
    )


def refuse_near(table: Table, columns: Collection[str], problems: list[RowProblem]) -> None:
    """Add to `problems` columns of `table` that are nearly one of `columns` of its form."""
    free = [column for column in columns if column not in table.header]
    for name in table.header:
        if name not in columns and (near := near_name(name, free)):
            accepted = f"{near}, if it is meant; else another name than this"
            problems.append(RowProblem(table.file, 1, name, name, accepted))
