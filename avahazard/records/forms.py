"""The tables of a file by their forms: columns known by their names, cells made plain."""

import datetime as dt
import math
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import PurePath
from typing import Literal

from avahazard.notes import ENGLISH, counted
from avahazard.records.cells import PLAIN_NUMBER as NUMBER
from avahazard.records.cells import USUAL_MARKS, number_alone, plain_cells
from avahazard.records.collection import Covariate, Event, Path
from avahazard.records.conventions import Conventions
from avahazard.records.errors import Problems, RowProblem
from avahazard.records.intake import Intake, UnderstoodColumn
from avahazard.records.meanings import ABOVE_SEA, EVERY, MEANINGS, known_name, near_name, squash
from avahazard.records.rows import EventRow, PathRow, ProfileRow, Row, StraightRow, VelocityRow
from avahazard.records.table import FileTable


def spell(table: FileTable, stored: Collection[str], problems: Problems) -> FileTable:
    """Known columns and `stored` covariates under their names; two that mean one are a problem."""
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
        columns={meant[name]: column for name, column in table.columns.items()},
        words=(*table.words, f"columns: {said}"),
    )


PLACES = ("runout_x_m", "runout_elevation_m", "left_profile", "easting_m", "lon")
"""Columns that say where an event stopped."""
Kind = Literal["paths", "profiles", "events", "velocities"]

KNOWN_FORMS = (
    "the columns of paths (path_id), profiles (path_id, x_m, y_m), events (event_id and path_id, "
    "or fall_height_m and runout_length_m, or h_over_l) or velocities (event_id, x_m or "
    "elevation_m, speed_m_s)"
)
OTHER_NAMES = "a columns.toml with the names here (import FILE --guess-columns writes one)"


def recognise(table: FileTable, problems: Problems, *, need_runout: bool = True) -> Kind | None:
    """Return the kind of `table`, or None after adding to `problems` what its header lacks."""
    columns, mapping = set(table.header), table.mapping
    kind = _kind(columns, (table.name or PurePath(table.file).stem).lower())
    if kind is None:
        accepted = f"in {mapping}, {KNOWN_FORMS}" if mapping else f"{OTHER_NAMES}; or {KNOWN_FORMS}"
        problems.append(RowProblem(table.file, table.first, "", ", ".join(table.header), accepted))
        return None
    lacking = [names for names in required(kind, columns, need_runout) if not columns & set(names)]
    for names in lacking:
        accepted = f"a column {' or '.join(names)}"
        accepted += f" in {mapping}" if mapping else f"; or {OTHER_NAMES}"
        problems.append(RowProblem(table.file, table.first, names[0], "", accepted))
    return None if lacking else kind


def _kind(columns: set[str], stem: str) -> Kind | None:
    if "event_id" in columns:
        speeds = "speed_m_s" in columns or stem.startswith(("velocit", "speed"))
        return "velocities" if speeds else "events"
    if "path_id" in columns:
        needed = 2 if stem.startswith("path") else 1
        points = len({"x_m", "y_m"} & columns) >= needed
        return "profiles" if points or stem.startswith("profile") else "paths"
    return next((kind for start, kind in _BY_NAME.items() if stem.startswith(start)), None)


_BY_NAME: dict[str, Kind] = {
    "path": "paths",
    "profile": "profiles",
    "event": "events",
    "velocit": "velocities",
    "speed": "velocities",
}


def required(kind: Kind, columns: set[str], need_runout: bool) -> list[tuple[str, ...]]:
    """Return groups of columns, of each of which one must be there."""
    if kind == "paths":
        return [("path_id",)]
    if kind == "profiles":
        return [("path_id",), ("x_m",), ("y_m",)]
    if kind == "velocities":
        return [("event_id",), ("speed_m_s",), ("x_m", "elevation_m")]
    straight = {"fall_height_m", "runout_length_m", "h_over_l"}
    if "path_id" not in columns and columns & straight:
        if "h_over_l" in columns:
            return [("event_id",)]
        heights = ("fall_height_m", "runout_elevation_m")
        return [("event_id",), heights, *([("runout_length_m",)] if need_runout else [])]
    needed: list[tuple[str, ...]] = [("event_id",), ("path_id",)]
    if need_runout:
        needed.append((*PLACES, *sorted(straight)))
    return needed


Content = Literal["number", "text"]
LARGEST = 1e30  # its square must still be a number
NOT_FINITE = re.compile(r"[+-]?(?:inf|infinity|nan)", re.IGNORECASE)


def column_kinds(records: Iterable[Path | Event]) -> dict[str, Content]:
    """Return how each covariate of stored records is held."""
    kinds: dict[str, Content] = {}
    for record in records:
        for name, value in record.covariates.items():
            kinds.setdefault(name, "text" if isinstance(value, str) else "number")
    return kinds


def read_covariates(
    tables: Sequence[FileTable],
    own_columns: Collection[str],
    stored: Mapping[str, Content],
    problems: Problems,
    notes: list[str],
) -> dict[tuple[str, int], dict[str, Covariate]]:
    """Return the covariates of every row of `tables`, keyed (file, line).

    A column is one of numbers where its meaning says so or most of its values are numbers,
    unless the records stored before hold it as text; empty cells are left out. Texts in a
    column of numbers, and numbers that are not finite or out of bounds, are added to
    `problems`. Numbers in a column of words are words, which is added to `notes`.
    """
    names = dict.fromkeys(c for t in tables for c in t.header if c not in own_columns)
    kinds = {name: stored.get(name) or _content(tables, name) for name in names}
    for name in names:
        notes += _mixed(tables, name) if kinds[name] == "text" else ()
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
                    accepted = _accepted(name, text, stored)
                    problems.append(RowProblem(table.file, line, name, text, accepted))
            found[table.file, line] = values
    return found


def _content(tables: Sequence[FileTable], name: str) -> Content:
    """A column of numbers and a few words is one of numbers with mistakes, not one of words."""
    if _means_numbers(name):
        return "number"
    found = sum((table.counts(name) for table in tables), Counter[str]())
    numbers = sum(n for text, n in found.items() if _like_a_number(text))
    return "number" if 2 * numbers > found.total() else "text"


def _mixed(tables: Sequence[FileTable], name: str) -> Iterator[str]:
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


def _accepted(name: str, text: str, stored: Mapping[str, Content]) -> str:
    number = f"a number of at most {LARGEST:g} in size" if _like_a_number(text) else "a number"
    if name in stored:
        why = f", as the records stored before hold in {name}"
    else:
        why = "" if _means_numbers(name) else ", as in most of the column"
    remedy = "" if _like_a_number(text) else f"; {number_alone(text)}"
    return f"{number}{why}, or an empty cell where it is missing{remedy}"


YEARS = ("date", "observed_from", "observed_to")
FIRST_YEAR = 1000


def check_ranges(
    table: FileTable, problems: Problems, notes: list[str], *, unusual: bool = False
) -> None:
    """Refuse the impossible and what is to come; note the unusual, unless all is `unusual`."""
    doubts: list[str] = []
    for column in table.header:
        beyond = _years_beyond if column in YEARS else _numbers_beyond
        refused, odd, accepted, what = beyond(column, table.counts(column))
        there = table.values(column) if refused or odd else ()
        rows = [(table.lines[k], text) for k, text in there if text in refused or text in odd]
        for line, text in rows:
            if text in refused:
                problems.append(RowProblem(table.file, line, column, text, accepted))
        if doubtful := [f"line {line}: {text}" for line, text in rows if text not in refused]:
            doubts.append(
                f"{table.file}: {column} {what} ({ENGLISH.few(doubtful)}). Are the unit and the "
                "value right? If so, use --unusual."
            )
        notes += _marks_among_numbers(table, column)
    if not unusual:
        notes += doubts


Beyond = tuple[set[str], set[str], str, str]
"""Texts that are impossible, that are unusual; what would be accepted; words for the unusual."""


def _numbers_beyond(column: str, texts: Collection[str]) -> Beyond:
    """The numbers of a column beyond its limits, few or none."""
    meaning = MEANINGS.get(column)
    if meaning is None or meaning.possible == EVERY:
        return set(), set(), "", ""
    (first, last), (low, high) = meaning.possible, meaning.usual
    unit = "m" if meaning.unit == ABOVE_SEA else meaning.unit
    numbers = {text: x for text in texts if (x := _number(text)) is not None}
    refused = {
        text
        for text, x in numbers.items()
        # What is not over 0 the form of a row refuses.
        if not first <= x <= last and (x > 0 or first < 0 or meaning.further)
    }
    odd = {t for t, x in numbers.items() if first <= x <= last and not low <= x <= high}
    accepted = f"a number from {first:g} to {last:g} {unit}".rstrip()
    return refused, odd, accepted, f"outside {low:g} to {high:g} {unit}".rstrip()


def _years_beyond(_column: str, texts: Collection[str]) -> Beyond:
    """The dates and years that are to come, or long ago."""
    # A day's grace: the clock may stand in another time zone.
    tomorrow = (dt.date.today() + dt.timedelta(1)).isoformat()
    dates = [text for text in texts if len(text) in (4, 10) and text[:4].isdigit()]
    refused = {text for text in dates if text > tomorrow[: len(text)]}
    odd = {text for text in dates if int(text[:4]) < FIRST_YEAR} - refused
    return refused, odd, "a date that is not in the future", f"before the year {FIRST_YEAR}"


FAR, FAR_OF_MARK = 10.0, 1.0
"""How many times the range of the others a repeated value, or a usual mark, lies beyond it."""


def _marks_among_numbers(table: FileTable, column: str) -> Iterator[str]:
    """Note a value far outside the rest that looks like a mark of unknown."""
    if column in MEANINGS and MEANINGS[column].content != "number":
        return
    counts = {x: (n, t) for t, n in table.counts(column).items() if (x := _number(t)) is not None}
    ordered = sorted(counts)
    for at in (0, -1):
        others = ordered[1:] if at == 0 else ordered[:-1]
        if len(others) < 3:
            return
        value, (low, high) = ordered[at], (others[0], others[-1])
        n, text = counts[value]
        beyond = max(low - value, value - high) / (high - low)
        if beyond > (FAR_OF_MARK if value in USUAL_MARKS else FAR if n > 1 else math.inf):
            yield (
                f"{table.file}: {column} holds {text} {n} times, far outside the other values "
                f"({low:g} to {high:g}). If it means unknown, import with --unknown={text}"
            )


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


FIRST_VALUES = 3


def understood(table: FileTable, form: str, columns: Collection[str]) -> list[UnderstoodColumn]:
    """Say it for every column of `table`; `columns` are those of its form."""
    found = []
    for name, column in table.columns.items():
        first = tuple(text for _, text in islice(table.values(name), FIRST_VALUES))
        if name in columns and name in MEANINGS:
            words, unit = MEANINGS[name].words, MEANINGS[name].unit
            meaning = words if name == column.spelt else f"{name}: {words}"
        else:
            unit = ""
            numbers = first and all(NUMBER.fullmatch(text) for _, text in table.values(name))
            kind = "numbers" if numbers else "words"
            kept = form in ("paths", "events")
            meaning = f"your own column, {kind}" if kept else "not used"
        found.append(UnderstoodColumn(table.file, form, column.spelt, meaning, unit, first))
    return found


FORMS: dict[Kind, tuple[type[Row], ...]] = {
    "paths": (PathRow,),
    "profiles": (ProfileRow,),
    "events": (EventRow, StraightRow),
    "velocities": (VelocityRow,),
}
COLUMNS = {
    kind: {column for form in forms for column in form.model_fields}
    | {column for column, meaning in MEANINGS.items() if kind in meaning.further}
    for kind, forms in FORMS.items()
}


def read_forms(
    sheets: Sequence[FileTable],
    intake: Intake,
    faults: Sequence[RowProblem],
    need_runout: bool,
    given: Conventions,
) -> Iterator[tuple[Kind, FileTable]]:
    """Yield the tables of one file whose form is known; `faults` are those of reading it.

    What is wrong goes to `intake.problems`, where a wrong header stands for the faults of the
    rows under it. Of a workbook with a known form, sheets of no form are left out and reported.
    """
    known = intake.known
    stored, ids = column_kinds((*known.paths, *known.events)), {e.event_id for e in known.events}
    unknown: list[tuple[FileTable, Problems]] = []
    found: list[tuple[Kind, FileTable]] = []
    wrong: Problems = []
    for sheet in sheets:
        table = spell(sheet, stored, wrong)
        of_header: Problems = []
        # Of events that are all stored the runouts are.
        whole = bool(ids) and "event_id" in table.header
        adds = need_runout and not (whole and all(map(ids.issuperset, table.blocks("event_id"))))
        kind = recognise(table, of_header, need_runout=adds)
        if kind is None and len(sheets) > 1 and not of_header[0].column:
            unknown.append((table, of_header))
            continue
        wrong += of_header
        if kind is None:
            continue
        free = sorted(COLUMNS[kind] - set(table.header))
        for name in table.header:
            if name not in COLUMNS[kind] and (near := near_name(name, free)):
                accepted = f"{near}, if it is meant; else another name than this"
                wrong.append(RowProblem(table.file, 1, name, name, accepted))
        table = plain_cells(table, given, intake.problems)
        check_ranges(table, intake.problems, intake.notes, unusual=given.unusual)
        rows = counted(len(table.lines), "row")
        intake.read.append(f"{table.file}: {kind}, {rows} ({', '.join(table.words)})")
        intake.understood += understood(table, kind, COLUMNS[kind])
        found.append((kind, table))
    for table, of_header in unknown:
        if found:
            intake.notes.append(f"{table.file}: not read, it has the columns of no form.")
        else:
            wrong += of_header
    headers = {problem.file for problem in wrong}
    intake.problems += [*wrong, *(fault for fault in faults if fault.file not in headers)]
    yield from found
