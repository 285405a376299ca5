"""`columns.toml`: what the columns of somebody's own table are in those of docs/data_forms.md."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile
from pathlib import Path as FilePath
from typing import Annotated

from pydantic import BeforeValidator, Field, model_validator

from avahazard.records.conventions import Conventions, Decimal, Order
from avahazard.records.errors import AvahazardError, did_you_mean
from avahazard.records.meanings import MEANINGS, known_unit, squash
from avahazard.records.table import Column, FileTable, OfRange, texts
from avahazard.records.toml_document import Strict, read_toml

BESIDE = "columns.toml"
HINT = (
    'Write for each column of docs/data_forms.md the one of the file, such as volume_m3 = {from = "'
    'Volume", unit = "km3"}; import FILE --guess-columns writes a first one.'
)


Names = Annotated[list[str], BeforeValidator(lambda one: [one] if isinstance(one, str) else one)]


class Source(Strict):
    """Where a column comes from: one column, several that make a date, or one value for all rows.

    `unit` is that of the numbers; `classes` gives words a number or another word each;
    `range` says which number stands for `10-20`. In a `value`, `{row}` is the number of the row.
    """

    names: Names = Field(default_factory=list, alias="from")
    value: str | int | float | None = None
    unit: str | None = None
    classes: dict[str, float | str] = Field(default_factory=dict)
    range: OfRange | None = None

    @model_validator(mode="after")
    def _one_origin(self) -> Source:
        if bool(self.names) == (self.value is not None):
            raise ValueError("either `from` or `value`")
        return self


NamedSource = Annotated[
    Source, BeforeValidator(lambda name: {"from": name} if isinstance(name, str) else name)
]


class TableMapping(Strict):
    """One table of a file: where it stands, and its columns under the names of the forms.

    `file` is a name with `*`, `header` and `units` are numbers of rows, `merged` cells hold their
    value in each row; rows with nothing in a column of `need` are left out; of the columns that
    are not mapped those in `keep` stay as one's own, all where it is not given.
    """

    file: str | None = None
    sheet: str | None = None
    header: int | None = None
    units: int | None = None
    merged: bool = False
    unknown: list[str | int | float] = Field(default_factory=list)
    decimal: Decimal | None = None
    dates: Order | None = None
    need: list[str] = Field(default_factory=list)
    keep: list[str] | None = None
    columns: dict[str, NamedSource] = Field(default_factory=dict)

    def needed(self) -> list[str]:
        """The columns of the file that it names."""
        found = [name for source in self.columns.values() for name in source.names]
        return list(dict.fromkeys([*found, *self.need, *(self.keep or ())]))


class Document(TableMapping):
    """One table, or several as `[[table]]`."""

    table: list[TableMapping] = Field(default_factory=list)


def read_mappings(file: FilePath) -> list[TableMapping]:
    """The tables of a `columns.toml`; refused where it is none, or a unit does not fit."""
    if not file.is_file():
        raise AvahazardError(f"There is no file {file}.", HINT)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise AvahazardError(f"{file} cannot be read as a text in UTF-8.", HINT) from error
    document = read_toml(str(file), text, Document, HINT)
    found = document.table or [document]
    for mapping in found:
        if not mapping.columns:
            raise AvahazardError(f"{file} has no [columns].", HINT)
        for name, source in mapping.columns.items():
            unit = MEANINGS[name].unit if name in MEANINGS else ""
            if source.unit is not None and not known_unit(source.unit, unit):
                raise AvahazardError(
                    f"{file}, columns, {name}: {source.unit!r} is no unit of it"
                    + (f", which counts in {unit}." if unit else "."),
                    "Write such as ft, km, km3, km/h, 1e6 m3; a column of your own has no unit.",
                )
    return found


def lacking(mapping: TableMapping, table: FileTable) -> list[str]:
    """The columns of the mapping that a table has not, each with what may be meant."""
    named = {squash(name) for name in table.header}
    absent = [name for name in mapping.needed() if squash(name) not in named]
    return [f"{name} {did_you_mean(name, table.header)}".strip() for name in absent]


def mapped(table: FileTable, mapping: TableMapping) -> FileTable:
    """The table under the names of the forms; its cells are as they were written."""
    at = {squash(name): name for name in table.header}
    columns: dict[str, Column] = {}
    used: set[str] = set()
    for name, source in mapping.columns.items():
        own = [at[squash(n)] for n in source.names]
        used |= set(own)
        if source.value is not None:
            value = str(source.value)
            cells = [value.replace("{row}", str(line)) for line in table.lines]
            column = Column(texts(cells), value)
        elif len(own) == 1:
            column = table.columns[own[0]]
        else:
            parts = [table.columns[n].texts.tolist() for n in own]
            column = Column(texts(_dates(parts)), ", ".join(own))
        known = known_unit(column.unit, MEANINGS[name].unit if name in MEANINGS else "")
        unit = source.unit or (column.unit if known else "")
        columns[name] = column._replace(unit=unit, classes=source.classes, range=source.range)
    spelt = (
        f"{name} is {column.spelt}" for name, column in columns.items() if name != column.spelt
    )
    words = [f"columns: {', '.join(spelt)}"]
    for name in table.header if mapping.keep is None else [at[squash(n)] for n in mapping.keep]:
        if name not in used:
            columns.setdefault(name, table.columns[name]._replace(unit=""))
    lines = table.lines
    needed = [columns.get(n) or table.columns[at[squash(n)]] for n in mapping.need]
    kept = [k for k in range(len(lines)) if all(column.texts[k] for column in needed)]
    if len(kept) < len(lines):
        words.append(f"{len(lines) - len(kept)} rows left out")
        lines = array("q", [lines[k] for k in kept])
        columns = {n: c._replace(texts=c.texts[kept]) for n, c in columns.items()}
    given = Conventions(mapping.decimal, mapping.dates, unknown=tuple(map(str, mapping.unknown)))
    return replace(table, lines=lines, columns=columns, words=(*table.words, *words), given=given)


def _dates(parts: Sequence[Sequence[str]]) -> list[str]:
    """Year, month and day of columns of their own as ISO dates, as far as they are known."""
    return [
        "-".join(text.removesuffix(".0").zfill(2) for text in takewhile(bool, row))
        for row in zip(*parts, strict=True)
    ]
