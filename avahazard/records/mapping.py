"""`columns.toml`: what the columns of somebody's own table are in those of docs/data_forms.md."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path as FilePath
from typing import Literal

from pydantic import Field, model_validator

from avahazard.records.conventions import Conversion, Decimal, Order
from avahazard.records.errors import AvahazardError, did_you_mean
from avahazard.records.meanings import MEANINGS, known_unit, squash
from avahazard.records.table import FileTable, Texts, texts
from avahazard.records.toml_document import Strict, read_toml

BESIDE = "columns.toml"
HINT = (
    'Write for each column of docs/data_forms.md the one of the file, such as volume_m3 = {from = "'
    'Volume", unit = "km3"}; import FILE --guess-columns writes a first one.'
)


class Source(Strict):
    """Where a column comes from: one column, several that make a date, or one value for all rows.

    `unit` is that of the numbers; `classes` gives words a number each; `range` says which number
    stands for `10-20`. In a `value`, `{row}` is the number of the row.
    """

    from_: str | list[str] | None = Field(None, alias="from")
    value: str | int | float | None = None
    unit: str | None = None
    classes: dict[str, float] = Field(default_factory=dict)
    range: Literal["geometric", "mean", "low", "high"] | None = None

    @model_validator(mode="after")
    def _one_origin(self) -> Source:
        if (self.from_ is None) == (self.value is None):
            raise ValueError("either `from` or `value`")
        return self

    @property
    def names(self) -> list[str]:
        """The columns of the file that it needs."""
        return [self.from_] if isinstance(self.from_, str) else list(self.from_ or ())


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
    columns: dict[str, str | Source] = Field(default_factory=dict)

    def sources(self) -> dict[str, Source]:
        """Each column with its source."""
        return {
            name: Source.model_validate({"from": found}) if isinstance(found, str) else found
            for name, found in self.columns.items()
        }

    def needed(self) -> list[str]:
        """The columns of the file that it names."""
        found = [name for source in self.sources().values() for name in source.names]
        return list(dict.fromkeys([*found, *self.need, *(self.keep or ())]))


class Document(TableMapping):
    """One table, or several as `[[table]]`."""

    table: list[TableMapping] = Field(default_factory=list)


def read_mappings(file: FilePath, text: str | None = None) -> list[TableMapping]:
    """The tables of a `columns.toml`.

    Raises `AvahazardError` where it is none, or holds a unit that is not one of its column.
    """
    if text is None:
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
        for name, source in mapping.sources().items():
            unit = MEANINGS[name].unit if name in MEANINGS else ""
            if source.unit is not None and not known_unit(source.unit, unit):
                raise AvahazardError(
                    f"{file}, columns, {name}: {source.unit!r} is no unit of it"
                    + (f", which counts in {unit}." if unit else "."),
                    "Write such as ft, km, km3, km/h, 1e6 m3; a column of your own has no unit.",
                )
    return found


def fits(mapping: TableMapping, file: str) -> bool:
    """Whether a file is the one that the mapping is for, by its name."""
    return mapping.file is None or fnmatch(FilePath(file).name, mapping.file)


def lacking(mapping: TableMapping, table: FileTable) -> list[str]:
    """The columns of the mapping that a table has not, each with what may be meant."""
    named = {squash(name) for name in table.header}
    absent = [name for name in mapping.needed() if squash(name) not in named]
    return [f"{name} {did_you_mean(name, table.header)}".strip() for name in absent]


def mapped(table: FileTable, mapping: TableMapping) -> FileTable:
    """The table under the names of the forms; its cells are as they were written."""
    at = {squash(name): name for name in table.header}
    sources = mapping.sources()
    columns: dict[str, Texts] = {}
    spelt: dict[str, str] = {}
    origin: dict[str, str] = {}
    conversions: dict[str, Conversion] = {}
    for name, source in sources.items():
        own = [at[squash(n)] for n in source.names]
        if source.value is not None:
            value = str(source.value)
            columns[name] = texts([value.replace("{row}", str(line)) for line in table.lines])
            spelt[name] = value
        elif len(own) == 1:
            columns[name], spelt[name], origin[own[0]] = table.columns[own[0]], own[0], name
        else:
            columns[name] = texts(_dates([table.columns[n].tolist() for n in own]))
            spelt[name] = ", ".join(own)
        unit = source.unit
        if unit is None and len(own) == 1 and name in MEANINGS and MEANINGS[name].unit:
            told_there = table.units.get(own[0], "")
            unit = told_there if known_unit(told_there, MEANINGS[name].unit) else None
        if unit or source.classes or source.range:
            conversions[name] = Conversion(unit, source.classes, source.range)
    used = {at[squash(n)] for source in sources.values() for n in source.names}
    kept = table.header if mapping.keep is None else [at[squash(n)] for n in mapping.keep]
    for name in kept:
        if name not in used and name not in columns:
            columns[name], origin[name] = table.columns[name], name
    needed = [columns.get(n, table.columns.get(at.get(squash(n), ""))) for n in mapping.need]
    told = (f"{name} is {n}" for n, name in spelt.items() if name != n)
    found = replace(
        table,
        header=tuple(columns),
        columns=columns,
        words=(*table.words, f"columns: {', '.join(told)}"),
        dated=frozenset((line, origin[n]) for line, n in table.dated if n in origin),
        written=None
        if table.written is None
        else frozenset((line, origin[n]) for line, n in table.written if n in origin),
        spelt=spelt,
        unknown=tuple(str(mark) for mark in mapping.unknown),
        decimal=mapping.decimal,
        dates=mapping.dates,
        conversions=conversions,
    )
    return _with_rows(found, [column for column in needed if column is not None])


def _dates(parts: Sequence[Sequence[str]]) -> list[str]:
    """Year, month and day of columns of their own as ISO dates, as far as they are known."""

    def joined(row: Iterable[str]) -> str:
        known = []
        for text in row:
            if not text:
                break
            known.append(text.removesuffix(".0").zfill(2))
        return "-".join(known)

    return [joined(row) for row in zip(*parts, strict=True)]


def _with_rows(table: FileTable, needed: Sequence[Texts]) -> FileTable:
    """Those rows that hold something in each of the columns `needed`."""
    if not needed:
        return table
    kept = [k for k, row in enumerate(zip(*needed, strict=True)) if all(row)]
    left = len(table.lines) - len(kept)
    if not left:
        return table
    lines = type(table.lines)("q", (table.lines[k] for k in kept))
    there = set(lines)
    columns: Mapping[str, Texts] = {name: cells[kept] for name, cells in table.columns.items()}
    return replace(
        table,
        lines=lines,
        columns=columns,
        words=(*table.words, f"{left} rows left out"),
        dated=frozenset(cell for cell in table.dated if cell[0] in there),
        written=None
        if table.written is None
        else frozenset(cell for cell in table.written if cell[0] in there),
    )
