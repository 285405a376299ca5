"""`columns.toml`: what the columns of somebody's own table are in those of docs/data_forms.md."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatch
from itertools import takewhile
from pathlib import Path as FilePath
from typing import Annotated, NamedTuple

from pydantic import BeforeValidator, Field, model_validator

from avahazard.notes import ENGLISH, counted
from avahazard.records.conventions import Conventions, Decimal, Order
from avahazard.records.errors import AvahazardError, Problems, RowProblem, did_you_mean
from avahazard.records.meanings import MEANINGS, known_unit, squash
from avahazard.records.sheet import read_tables
from avahazard.records.table import Column, FileTable, OfRange, SheetLayout, texts
from avahazard.records.toml_document import Strict, read_toml

BESIDE = "columns.toml"
MOST_NAMES = 12
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

    def needed(self) -> dict[str, str]:
        """The columns of the file that it names, each with the key that does."""
        columns = {name: key for key, source in self.columns.items() for name in source.names}
        others = dict.fromkeys(self.need, "need") | dict.fromkeys(self.keep or (), "keep")
        return columns | {name: key for name, key in others.items() if name not in columns}


ABOVE_COLUMNS = TableMapping.model_fields.keys() - {"need", "keep"}


class Document(TableMapping):
    """One table, or several as `[[table]]`."""

    table: list[TableMapping] = Field(default_factory=list)


def read_mappings(file: FilePath) -> dict[str, TableMapping]:
    """The tables of a `columns.toml`, by what messages call them.

    Refused where it is none, or a unit does not fit.
    """
    if not file.is_file():
        raise AvahazardError(f"There is no file {file}.", HINT)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise AvahazardError(f"{file} cannot be read as a text in UTF-8.", HINT) from error
    document = read_toml(str(file), text, Document, HINT)
    of_tables = {f"{file}, table {k}": table for k, table in enumerate(document.table, 1)}
    found: dict[str, TableMapping] = of_tables or {str(file): document}
    for place, mapping in found.items():
        if not mapping.model_fields_set:
            raise AvahazardError(f"{place} has no [columns].", HINT)
        for name, source in mapping.columns.items():
            unit = MEANINGS[name].unit if name in MEANINGS else ""
            if source.unit is not None and not known_unit(source.unit, unit):
                raise AvahazardError(
                    f"{place}, columns, {name}: {source.unit!r} is no unit of it"
                    + (f", which counts in {unit}." if unit else "."),
                    "Write such as ft, km, cu yd, km/h, 1e6 m3; a column of your own has no unit.",
                )
    return found


class Trial(NamedTuple):
    """A table held against a mapping: what it lacks, None where it is none of those meant."""

    mapping: TableMapping
    file: str  # with the sheet
    title: str
    lacks: Problems | None


def try_mapping(name: str, mapping: TableMapping, table: FileTable) -> Trial:
    """Hold a table against the mapping of this name.

    One that names neither file nor sheet means the tables that have any of its columns.
    """
    there = {squash(column) for column in table.header}
    needed = mapping.needed()
    lacks: Problems = []
    for column, key in needed.items():
        if squash(column) not in there:
            what = f"a column of {table.file}"
            if key in ABOVE_COLUMNS:
                what += f" (the key {key} stands above [columns])"
            lacks.append(RowProblem(name, 0, key, column, _one_of(what, column, table.header)))
    alike = mapping.file or mapping.sheet or not lacks or len(lacks) < len(needed)
    meant = alike and mapping.sheet in (None, table.title or None)
    return Trial(mapping, table.file, table.title, lacks if meant else None)


def _one_of(what: str, name: str, known: Sequence[str]) -> str:
    close = did_you_mean(name, known).rstrip()
    return f"{what}. {close}" if close else f"{what}: {ENGLISH.few(known, MOST_NAMES) or 'none'}"


@dataclass
class Mappings:
    """The mapping `given` for all files, else the one beside each, and the tables they were for.

    Cells with one of the marks `unknown` are empty where a column is needed.
    """

    given: FilePath | None
    unknown: Sequence[str]
    found: dict[FilePath, dict[str, TableMapping]] = field(default_factory=dict)
    trials: list[Trial] = field(default_factory=list)

    def tables(self, file: FilePath, problems: Problems, notes: list[str]) -> list[FileTable]:
        """The tables of a file, by the mappings that are for it, if any."""
        where = self.given or file.parent / BESIDE
        if where not in self.found:
            self.found[where] = read_mappings(where) if self.given or where.is_file() else {}
        found: list[FileTable] = []
        tried: list[Trial] = []
        for name, mapping in self.found[where].items():
            if not fnmatch(file.name, mapping.file or "*"):
                continue
            faults: Problems = []
            layout = SheetLayout(mapping.header, mapping.units, mapping.merged)
            tables = {table.file: table for table in read_tables(file, faults, layout)}
            of_one = [try_mapping(name, mapping, table) for table in tables.values()]
            used = [trial.file for trial in of_one if trial.lacks == []]
            found += [replace(mapped(tables[t], mapping, self.unknown), mapping=name) for t in used]
            problems += [fault for fault in faults if fault.file in used]
            sheets = (str(file), f"{file}, sheet {mapping.sheet}") if mapping.sheet else ()
            unread = [f for f in faults if f.file not in tables and f.file in (sheets or (f.file,))]
            if unread and (mapping.file or mapping.sheet):
                of_one.append(Trial(mapping, str(file), "", unread))
            tried += of_one
        self.trials += tried
        lacks = [fault for trial in tried for fault in trial.lacks or ()]
        if not found and not lacks:
            return read_tables(file, problems)
        problems += () if found else lacks
        left = {trial.file for trial in tried}.difference(table.file for table in found)
        if found and left:
            notes.append(f"{', '.join(sorted(left))}: not read, {where} is for other tables.")
        return found

    def unused(self, notes: list[str]) -> Problems:
        """What is wrong with mappings by which no table was read; a note on those for others."""
        problems: Problems = []
        others: Problems = []
        taken = {trial.file for trial in self.trials if trial.lacks == []}
        for name, mapping in (item for found in self.found.values() for item in found.items()):
            tried = [trial for trial in self.trials if trial.mapping is mapping]
            if any(trial.lacks == [] for trial in tried):
                continue
            one = mapping.sheet or "*" not in (mapping.file or "*")
            near = [t.lacks for t in tried if t.lacks and (one or t.file not in taken)]
            titles = list(dict.fromkeys(trial.title for trial in tried if trial.title))
            if near:
                nearest = min(near, key=len)
                problems += nearest
            elif mapping.file and not tried:
                accepted = "the name of an imported file"
                others.append(RowProblem(name, 0, "file", mapping.file, accepted))
            elif mapping.sheet:
                what = "a sheet of an imported workbook"
                what += "" if mapping.file else ' (write file = "…" if it is of another)'
                accepted = _one_of(what, mapping.sheet, titles)
                fault = RowProblem(name, 0, "sheet", mapping.sheet, accepted)
                (problems if titles else others).append(fault)
            else:
                columns, accepted = ENGLISH.few([*mapping.needed()]), "columns of an imported table"
                others.append(RowProblem(name, 0, "", columns, accepted))
        if self.given and not taken:
            return problems + others
        if others:
            names = "; ".join(other.file for other in others)
            notes.append(f"{names}: not used, no imported table is one for it.")
        return problems


def mapped(table: FileTable, mapping: TableMapping, unknown: Sequence[str] = ()) -> FileTable:
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
    words = [f"columns: {named}"] if (named := ", ".join(spelt)) else []
    for name in table.header if mapping.keep is None else [at[squash(n)] for n in mapping.keep]:
        if name not in used:
            columns.setdefault(name, table.columns[name]._replace(unit=""))
    lines = table.lines
    needed = [columns.get(n) or table.columns[at[squash(n)]] for n in mapping.need]
    marks = (*unknown, *map(str, mapping.unknown))
    given = Conventions(mapping.decimal, mapping.dates, unknown=marks)
    absent = {text for c in needed for text in set(c.texts.tolist()) if given.is_unknown(text)}
    absent.add("")
    kept = [k for k in range(len(lines)) if absent.isdisjoint(c.texts[k] for c in needed)]
    if len(kept) < len(lines):
        words.append(f"{counted(len(lines) - len(kept), 'row')} left out")
        lines = array("q", [lines[k] for k in kept])
        columns = {n: c._replace(texts=c.texts[kept]) for n, c in columns.items()}
    return replace(table, lines=lines, columns=columns, words=(*table.words, *words), given=given)


def _dates(parts: Sequence[Sequence[str]]) -> list[str]:
    """Year, month and day of columns of their own as ISO dates, as far as they are known."""
    return [
        "-".join(text.removesuffix(".0").zfill(2) for text in takewhile(bool, row))
        for row in zip(*parts, strict=True)
    ]
