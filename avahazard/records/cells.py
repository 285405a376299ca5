"""The cells of a table as plain numbers and ISO dates, or refused where they are ambiguous."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace

from avahazard.records.conventions import (
    Conventions,
    Decimal,
    Order,
    canonical,
    is_number,
    read_dates,
)
from avahazard.records.errors import Problems, RowProblem
from avahazard.records.meanings import MEANINGS, factor, known_unit
from avahazard.records.table import FileTable, OfRange

Cell = tuple[int, str, str]  # index of the row, column, text
Edits = dict[str, dict[int, str]]  # other texts, by column and row
PLAIN_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
ODD = re.compile("[,\\s'’\u2212]")  # what a number of a file with commas does not hold, unquoted
ODD_ELSEWHERE = re.compile("[.,\\s'’\u2212]")
DECIMAL = {"point": "decimal points", "comma": "decimal commas"}
LIKELY_MARKS = {
    "?", "??", "-", "--", "–", "—", "na", "n/a", "n.a.", "nan", "null", "none",
    "k.a.", "k. a.", "unbekannt", "inconnu", "sconosciuto", "ukjent", "unknown",
}  # fmt: skip
AMBIGUOUS = (
    "a number: is this sign a decimal one or of thousands? Write decimal = "
    '"comma" (or "point") in a columns.toml beside the file, or import with --decimal comma'
)
UNKNOWN_MARK = "unknown = [{0!r}] in columns.toml, or import with --unknown {0!r}"
MADE_A_DATE = "the text that was meant: the spreadsheet holds a date here"


def plain_cells(table: FileTable, given: Conventions, problems: Problems) -> FileTable:
    """Return `table` with numbers such as 1234.5 and dates such as 1950-02-13, and its notes.

    The decimal sign is one in the whole file. Where the file does not show it and `given` does
    not say it, ambiguous numbers are added to `problems`, as are ambiguous dates. Marks of unknown
    become empty cells where `given` names them.
    """
    unknown = replace(given, unknown=(*given.unknown, *table.given.unknown))
    table = _without_marks(table, unknown, problems)
    table = _with_plain_numbers(table, table.given.decimal or given.decimal, problems)
    table = _with_iso_dates(table, table.given.dates or given.dates, problems)
    table = _in_their_units(table)
    faults = []
    for name, column in table.columns.items():
        meaning = MEANINGS.get(name)
        if column.dated and meaning and meaning.content in ("name", "text"):
            texts = zip(table.lines, column.texts, strict=True)
            faults += [(line, name, text) for line, text in texts if line in column.dated]
    problems += [RowProblem(table.file, *fault, MADE_A_DATE) for fault in sorted(faults)]
    return table


def _edited(table: FileTable, edits: Edits, words: Sequence[str]) -> FileTable:
    """The table with other texts in some rows of its columns, and more words of how it was read."""
    columns = dict(table.columns)
    for name, edited in edits.items():
        texts = columns[name].texts.copy()
        for k, text in edited.items():
            texts[k] = text
        columns[name] = columns[name]._replace(texts=texts)
    return replace(table, columns=columns, words=(*table.words, *words))


def _without_marks(table: FileTable, given: Conventions, problems: Problems) -> FileTable:
    """Empty the cells that mean unknown; refuse likely marks that nobody has named."""
    edits: Edits = {}
    accepted = f"an empty cell where it is unknown; or {UNKNOWN_MARK}"
    for name in table.columns:
        found = table.counts(name)
        marks = {text for text in found if given.is_unknown(text)}
        if marks:
            edits[name] = {k: "" for k, text in table.values(name) if text in marks}
        if _holds_numbers(name, table) or name == "date":
            likely = {text for text in found if text.casefold() in LIKELY_MARKS} - marks
            problems += [
                RowProblem(table.file, table.lines[k], name, text, accepted.format(text))
                for k, text in (table.values(name) if likely else ())
                if text in likely
            ]
    emptied = sum(map(len, edits.values()))
    return _edited(table, edits, [f"{emptied} cells unknown"] if emptied else [])


def _with_plain_numbers(table: FileTable, decimal: Decimal | None, problems: Problems) -> FileTable:
    columns = [name for name in table.header if _holds_numbers(name, table)]
    odd = ODD if table.separator == "," else ODD_ELSEWHERE
    if not any(odd.search("".join(block)) for c in columns for block in table.blocks(c)):
        return table
    cells = [
        (k, column, text)
        for column in columns
        for k, text in table.values(column)
        if table.separator or table.lines[k] in table.columns[column].written
    ]
    chosen = decimal or _decided(table, cells, problems)
    if chosen is None or not cells:
        return table
    edits: Edits = {}
    grouped = False
    for k, column, text in cells:
        found = canonical(text, chosen)
        if found is not None and found != text:
            grouped = grouped or len(found) < len(text)
            edits.setdefault(column, {})[k] = found
    words = [DECIMAL[chosen] if table.separator else f"texts with {DECIMAL[chosen]}"]
    return _edited(table, edits, [*words, *(["thousands in groups"] if grouped else [])])


def _decided(table: FileTable, cells: Sequence[Cell], problems: Problems) -> Decimal | None:
    """The decimal sign that the numbers show, None after adding to `problems`."""
    found: dict[str, list[Cell]] = {"point": [], "comma": [], "both": []}
    for cell in cells:
        point, comma = canonical(cell[2], "point"), canonical(cell[2], "comma")
        if point != comma:  # integers and words say nothing of the sign
            found["point" if comma is None else "comma" if point is None else "both"].append(cell)
    signs: tuple[Decimal, Decimal] = ("point", "comma")
    sign, rarer = sorted(signs, key=lambda sign: -len(found[sign]))
    # Between commas a point is the decimal one: so programs write numbers.
    wrong = [cell for cell in found["both"] if table.separator != "," or "," in cell[2]]
    accepted = AMBIGUOUS
    if found[rarer]:
        wrong, first = found[rarer], table.lines[found[sign][0][0]]
        accepted = f"a decimal {sign}, as in line {first}: one sign in a file"
    elif found[sign]:
        return sign
    for row, column, text in wrong:
        problems.append(RowProblem(table.file, table.lines[row], column, text, accepted))
    return None if wrong else "point"


def _with_iso_dates(table: FileTable, order: Order | None, problems: Problems) -> FileTable:
    found = dict(table.values("date"))
    rows, texts = list(found), list(found.values())
    dates, faults, words = read_dates(texts, order, table.first_day)
    for place, accepted in faults:
        line = table.lines[rows[place]]
        problems.append(RowProblem(table.file, line, "date", texts[place], accepted))
    edits = {k: date for k, date in zip(rows, dates, strict=True) if date != found[k]}
    return _edited(table, {"date": edits} if edits else {}, [words] if words else [])


NUMBER = r"([0-9][0-9., '’]*(?:[eE]\+?[0-9]+)?)"
RANGE = re.compile(rf"[~≈]?\s*{NUMBER}\s*(?:-|–|—|\.\.|to|bis|à|a|til)\s*{NUMBER}")
USUAL_MARKS = frozenset((-99.0, -999.0, -9999.0, -99999.0, 999.0, 9999.0, 99999.0))


def _in_their_units(table: FileTable) -> FileTable:
    """Replace classes, ranges and units of a mapping, by numbers of the column's unit."""
    edits: Edits = {}
    for name, column in table.columns.items():
        classes = {word.casefold(): to for word, to in (column.classes or {}).items()}
        if not (column.unit or classes or column.range):
            continue
        times = factor(column.unit, MEANINGS[name].unit) if column.unit else None
        edited = edits[name] = dict[int, str]()
        for k, text in table.values(name):
            value = classes.get(text.casefold())
            if value is None:
                if PLAIN_NUMBER.fullmatch(text):
                    value = float(text)
                elif found := RANGE.fullmatch(text):
                    value = _of_range(found.groups(), column.range)
                if value is not None and times is not None:
                    value *= times
            if value is not None:
                edited[k] = value if isinstance(value, str) else f"{value:.12g}"
    return _edited(table, edits, ())


def with_remedy(problem: RowProblem) -> RowProblem:
    """A problem with what an option or a `columns.toml` can do about its value, if anything."""
    meaning, text, extra = MEANINGS.get(problem.column), problem.value, ""
    if meaning is None or meaning.content != "number" or not text:
        return problem
    if is_number(text):
        mark = canonical(text, "point")
        if mark is not None and float(mark) in USUAL_MARKS:
            extra = f"if it means unknown, import with --unknown={text}"
    elif RANGE.fullmatch(text):
        usual = usual_of_range(problem.column)
        extra = f'a range needs range = "{usual}" (or low, high) in columns.toml'
    elif known_unit(text, meaning.unit) and not text[0].isdigit():
        extra = f"a row of units needs units = {problem.line} in columns.toml"
    elif "--unknown" not in problem.accepted:
        extra = number_alone(text)
    return replace(problem, accepted=f"{problem.accepted}; {extra}") if extra else problem


def number_alone(text: str) -> str:
    """What to write in a column of numbers for a text with a number, or none."""
    found = re.search(NUMBER, text)
    if found is None:
        return f"if it means unknown, {UNKNOWN_MARK.format(text)}"
    number = found.group().rstrip(" .,'’")
    return f"the number alone, such as {number}"


def usual_of_range(column: str) -> OfRange:
    """Which number usually stands for a range: volumes spread over orders of magnitude."""
    return "geometric" if column == "volume_m3" else "mean"


def _of_range(ends: Sequence[str], kind: OfRange | None) -> float | None:
    low, high = (float(canonical(end.strip(), "point") or "nan") for end in ends)
    if kind is None or not low < high:
        return None
    middle = {"mean": 0.5 * (low + high), "geometric": math.sqrt(low * high)}
    return {"low": low, "high": high, **middle}[kind]


def _holds_numbers(column: str, table: FileTable) -> bool:
    """A known column of numbers, or one of one's own in which most values are numbers."""
    meaning = MEANINGS.get(column)
    if meaning:
        return meaning.content in ("number", "flag")
    found = table.counts(column)
    return 2 * sum(n for text, n in found.items() if is_number(text)) > found.total()
