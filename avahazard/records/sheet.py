"""The tables of a text file or a workbook as they were written: encoding, separators, sheets."""

import codecs
import csv
import datetime as dt
import io
import re
import unicodedata
import warnings
import zipfile
from collections import defaultdict
from collections.abc import Iterator
from itertools import islice
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np

from avahazard.arrays import Ints
from avahazard.records.conventions import FIRST_DAY, is_number
from avahazard.records.errors import Problems, RowProblem
from avahazard.records.meanings import known_name
from avahazard.records.table import LOOKED_AT, PLAIN, FileTable, Line, SheetLayout, filled


def read_tables(path: FilePath, problems: Problems, layout: SheetLayout = PLAIN) -> list[FileTable]:
    """Read the tables of a file, cells as written; what is wrong is added to `problems`."""
    file, raw = str(path), path.read_bytes()
    if raw.startswith((ZIP, OLE)):  # whatever its name
        return _read_sheets(file, raw, problems, layout)
    text = decode(file, raw, problems)
    del raw
    table = text and _split(file, *text, problems, layout)
    return [table] if table else []


HEADER_ACCEPTED = "a header row with the names of the columns"
TEXT_ACCEPTED = "a text file in UTF-8 (in a spreadsheet: save as .xlsx, or as 'CSV UTF-8')"
WORKBOOKS = (".xlsx", ".xlsm", ".xls", ".xlsb", ".ods")
MARKS = (
    (codecs.BOM_UTF8, "utf-8", "UTF-8 with a byte order mark"),
    (codecs.BOM_UTF32_LE, "utf-32-le", "UTF-32"),
    (codecs.BOM_UTF32_BE, "utf-32-be", "UTF-32"),
    (codecs.BOM_UTF16_LE, "utf-16-le", "UTF-16"),
    (codecs.BOM_UTF16_BE, "utf-16-be", "UTF-16"),
)
ZERO = re.compile("\0")
WORD = re.compile(r"\w*[^\W\x00-\x7f]\w*")
# Signs that no word holds at these places: what letters of other code pages become in cp1252.
FOREIGN = re.compile(
    "\0|(?<=[^\\W\\d_])(?:[‚ƒ„…†‡ˆ‰‹]|[ŠŒŽŸ](?=[a-z])|[“”•–—˜™›¡¢£¤¥¦§¨©«¬®¯±´¶·¸»¼½¾¿×÷](?=[^\\W\\d_]))"
)


def decode(file: str, raw: bytes, problems: Problems) -> tuple[str, str] | None:
    """Return the text of `raw` and the name of its encoding; None after adding to `problems`.

    A byte order mark decides, else UTF-8 where valid, else Windows-1252 with words of a language.
    """

    def refuse(line: int, byte: int) -> None:
        accepted = DAMAGED if PurePath(file).suffix.lower() in WORKBOOKS else TEXT_ACCEPTED
        problems.append(RowProblem(file, line, "", f"byte 0x{byte:02x}", accepted))

    invalid: list[int] = []
    for codec, name in _encodings(raw):
        try:
            text, encoding = raw.decode(codec), name
            break
        except UnicodeDecodeError as error:
            invalid.append(error.start)
    else:
        refuse(raw.count(b"\n", 0, invalid[-1]) + 1, raw[invalid[-1]])
        return None
    if wrong := (FOREIGN if invalid else ZERO).search(text):
        refuse(text.count("\n", 0, wrong.start()) + 1, wrong.group().encode("cp1252")[0])
        return None
    if invalid:
        letters = (
            word for word in WORD.findall(text) if any(c > "\x7f" and c.isalpha() for c in word)
        )
        example = next((f"such as {word!r}" for word in letters), f"byte 0x{raw[invalid[0]]:02x}")
        encoding = f"{encoding} ({example})"
    return unicodedata.normalize("NFC", text.removeprefix("\ufeff")), encoding


def _encodings(raw: bytes) -> list[tuple[str, str]]:
    """The codecs that are tried, one after the other, with their names."""
    for mark, codec, name in MARKS:
        if raw.startswith(mark):
            return [(codec, name)]
    # UTF-16 without its mark shows by zeros at every other byte of an ASCII header.
    head = raw[:200]
    even, odd = head[::2].count(0), head[1::2].count(0)
    if odd > 0.4 * len(head) and even == 0:
        return [("utf-16-le", "UTF-16")]
    if even > 0.4 * len(head) and odd == 0:
        return [("utf-16-be", "UTF-16")]
    return [("utf-8", "UTF-8"), ("cp1252", "Windows-1252")]


SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
LINE = re.compile(r"[^\r\n]*(?:\r\n?|\n)|[^\r\n]+")
HINT = re.compile(r"sep=(.)\r?\n", re.IGNORECASE)  # what Excel writes for itself


def _split(
    file: str, text: str, encoding: str, problems: Problems, layout: SheetLayout
) -> FileTable | None:
    start = HINT.match(text)
    separator = start.group(1) if start else _separator(text)
    if separator not in SEPARATORS:
        names = ", ".join(SEPARATORS.values())
        problems.append(RowProblem(file, 1, "", separator, f"values separated by {names}"))
        return None
    words = (encoding, SEPARATORS[separator])
    empty = FileTable(file, name=PurePath(file).stem, words=words, separator=separator)
    discontinuous: Problems = []
    wrong: Problems = []
    rows = islice(_filled(file, text, separator, discontinuous), 1 if start else 0, None)
    table = filled(empty, rows, wrong, layout)
    if table is None and not wrong:
        wrong.append(RowProblem(file, 1, "", "", HEADER_ACCEPTED))
    problems += discontinuous or wrong
    return None if discontinuous else table


def _filled(file: str, text: str, separator: str, problems: Problems) -> Iterator[Line]:
    """The rows that hold anything, with the line where each begins, as far as they can be read."""
    # Lines one by one: a second text would be four times as large.
    lines = (found.group() for found in LINE.finditer(text))
    reader = csv.reader(lines, delimiter=separator, strict=True)
    line = 1
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells):
                yield line, cells
            line = reader.line_num + 1
    except csv.Error as error:
        accepted = f"rows of values separated by {SEPARATORS[separator]}"
        problems.append(RowProblem(file, line, "", str(error), accepted))


def _separator(text: str) -> str:
    """The one by which the header has the most known columns; else the most words, or columns."""

    def rank(separator: str) -> tuple[int, int, int]:
        begin = [row for _, row in islice(_filled("", text, separator, []), LOOKED_AT)]
        known = (sum(known_name(name) is not None for name in row) for row in begin)
        # Decimal commas make columns of numbers, but none of a header.
        words = (sum(not is_number(cell) for cell in row) for row in begin)
        return max(known, default=0), max(words, default=0), max(map(len, begin), default=0)

    return max(SEPARATORS, key=rank)


ZIP, OLE = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"
SHEET_ACCEPTED = "a workbook (.xlsx, .xls, .ods) without a password, or a text file (CSV)"
DAMAGED = (
    "a workbook that can be read: this file is damaged; take another copy of it, or open it in a "
    "spreadsheet and save it again"
)
MOST_BYTES = 1_000_000_000  # unpacked; a small file can hold endless zeros


def _read_sheets(file: str, raw: bytes, problems: Problems, layout: SheetLayout) -> list[FileTable]:
    try:
        parts = zipfile.ZipFile(io.BytesIO(raw)) if raw.startswith(ZIP) else None
        if parts and sum(part.file_size for part in parts.infolist()) > MOST_BYTES:
            raise zipfile.BadZipFile
        xlsx = parts is not None and "xl/workbook.xml" in parts.namelist()
        grids = _of_xlsx(raw) if xlsx else _of_others(raw, parts)
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException:  # a panic of the library, which is in Rust, is no Exception
        accepted = DAMAGED if raw.startswith(ZIP) else SHEET_ACCEPTED
        problems.append(RowProblem(file, 0, "", PurePath(file).name, accepted))
        return []
    before = len(problems)
    found = [_sheet(file, grid, len(grids) > 1, layout, problems) for grid in grids]
    if not any(found) and len(problems) == before:
        problems.append(RowProblem(file, 1, "", "", HEADER_ACCEPTED))
    return [table for table in found if table is not None]


class Grid(NamedTuple):
    """A sheet as a library gives it: cells `(value, its fault or none)` by row and column."""

    title: str
    rows: list[list[tuple[Any, str]]]
    merged: list[tuple[int, int, int, int]]  # first row and column, last row and column, from 0
    words: tuple[str, ...]
    first_day: dt.date


def _of_xlsx(raw: bytes) -> list[Grid]:
    book = _load(raw, values=False)
    formulas = {
        (sheet.title, cell.coordinate)
        for sheet in book.worksheets
        for row in sheet.iter_rows()
        for cell in row
        if cell.data_type == "f"
    }
    if formulas:
        book = _load(raw, values=True)

    def read(title: str, cell: Any) -> tuple[Any, str]:
        if cell.data_type == "e":
            return cell.value, NOT_COMPUTED
        empty = cell.value is None and (title, cell.coordinate) in formulas
        return cell.value, NOT_SAVED if empty else ""

    found = []
    for sheet in book.worksheets:
        hidden = sum(d.hidden for d in sheet.row_dimensions.values())
        words = [f"{hidden} hidden rows among them"] if hidden else []
        words += ["a hidden sheet"] if sheet.sheet_state != "visible" else []
        merged = [
            (r.min_row - 1, r.min_col - 1, r.max_row - 1, r.max_col - 1)
            for r in sheet.merged_cells.ranges
        ]
        rows = [[read(sheet.title, cell) for cell in row] for row in sheet.iter_rows(min_row=1)]
        found.append(Grid(sheet.title, rows, merged, tuple(words), book.epoch.date()))
    return found


def _of_others(raw: bytes, parts: zipfile.ZipFile | None) -> list[Grid]:
    """Sheets of an `.xls`, `.xlsb` or `.ods`, whose libraries are one."""
    from python_calamine import CalamineWorkbook, SheetTypeEnum, SheetVisibleEnum  # noqa: PLC0415 (one format of many)

    if raw.startswith(OLE) and not _ends(raw):
        raise zipfile.BadZipFile
    book = CalamineWorkbook.from_filelike(io.BytesIO(raw))
    # Of an .ods it does not tell which cells are merged.
    content = parts.read("content.xml") if parts and "content.xml" in parts.namelist() else b""
    spanned = ROWS_SPANNED.search(content) is not None
    found = []
    for of_sheet in book.sheets_metadata:
        if of_sheet.typ != SheetTypeEnum.WorkSheet:
            continue
        sheet = book.get_sheet_by_name(of_sheet.name)
        rows = [
            [(None if v == "" else v, NOT_COMPUTED if _is_error(v) else "") for v in row]
            for row in sheet.to_python(skip_empty_area=False)
        ]
        merged = [(*first, *last) for first, last in sheet.merged_cell_ranges or ()]
        if spanned:
            merged = [(len(rows), 0, len(rows), 0)]
        hidden = of_sheet.visible != SheetVisibleEnum.Visible
        words = ("a hidden sheet",) if hidden else ()
        found.append(Grid(of_sheet.name, rows, merged, words, FIRST_DAY))
    return found


def _ends(raw: bytes) -> bool:
    """Whether the chains of sectors of an `.xls` end: the library follows a ring for ever."""

    def numbers(at: int, n: int) -> Ints:
        return np.frombuffer(raw[at : at + 4 * n], "<u4").astype(np.int64)

    def sector(k: int) -> Ints:
        return numbers((k + 1) << shift, size)

    def acyclic(following: Ints) -> bool:
        n = len(following)
        after = np.append(np.where(following < n, following, n), n)
        for _ in range(n.bit_length()):
            after = after[after]
        return bool(np.all(after == n))

    shift = int.from_bytes(raw[30:32], "little")
    if shift not in (9, 12):
        return False
    size, lists, seen = (1 << shift) // 4, [numbers(76, 109)], set[int]()
    more = int(numbers(68, 1)[0])
    while (more + 1) << shift < len(raw):
        if more in seen or len(last := sector(more)) < size:
            return False
        seen.add(more)
        lists.append(last[:-1])
        more = int(last[-1])
    present = [int(k) for k in np.concatenate(lists) if (int(k) + 1) << shift < len(raw)]
    if not present:
        return False
    table = np.concatenate([sector(k) for k in present])
    if not acyclic(table):
        return False
    small, k = [], int(numbers(60, 1)[0])
    while k < len(table):
        small.append(sector(k))
        k = int(table[k])
    return not small or acyclic(np.concatenate(small))


ROWS_SPANNED = re.compile(rb'number-rows-spanned="(?:[2-9]|[1-9][0-9]+)"')
NOT_COMPUTED = "a value: the spreadsheet could not compute this cell"
NOT_SAVED = "the value of the formula: open the file in a spreadsheet and save it"


def _is_error(value: Any) -> bool:
    return isinstance(value, str) and value.startswith("#") and value.rstrip("!?/A").isupper()


def _load(raw: bytes, *, values: bool) -> Any:
    from openpyxl import load_workbook  # noqa: PLC0415 (slow to import)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what it leaves out: colours, lists of choices
        return load_workbook(io.BytesIO(raw), data_only=values)


def _sheet(
    file: str, grid: Grid, several: bool, layout: SheetLayout, problems: Problems
) -> FileTable | None:
    from openpyxl.utils import get_column_letter  # noqa: PLC0415 (slow to import)

    label = f"{file}, sheet {grid.title}" if several else file
    for top, left, bottom, right in grid.merged if layout.merged else ():
        for row in grid.rows[top : bottom + 1]:
            row[left : right + 1] = [grid.rows[top][left]] * (right + 1 - left)
    lines: list[Line] = []
    dated: defaultdict[int, set[int]] = defaultdict(set)
    written: defaultdict[int, set[int]] = defaultdict(set)
    for line, row in enumerate(grid.rows, 1):
        texts = []
        for column, (value, fault) in enumerate(row):
            text = cell_text(value)
            if fault and line >= (layout.header or 0):
                problems.append(RowProblem(label, line, get_column_letter(column + 1), text, fault))
            if isinstance(value, dt.date):
                dated[column].add(line)
            elif isinstance(value, str) and is_number(text):
                written[column].add(line)
            texts.append(text)
        if any(texts):
            lines.append((line, tuple(texts)))
    name, words = grid.title if several else PurePath(file).stem, ("workbook", *grid.words)
    empty = FileTable(
        label, name=name, words=words, separator="", title=grid.title, first_day=grid.first_day
    )
    table = filled(empty, lines, problems, layout, dated, written)
    first = table.first if table else layout.header or 1
    for top, _, bottom, _ in () if layout.merged or not lines else grid.merged:
        if bottom + 1 > first:
            accepted = "cells that are not merged: each row with values of its own (or merged = "
            accepted += "true in columns.toml)"
            problems.append(RowProblem(label, top + 1, "", "merged cells", accepted))
    return table


def cell_text(value: Any) -> str:
    """A value of a spreadsheet or another program as the text of a cell, empty for none."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    if isinstance(value, dt.datetime):
        return value.date().isoformat()
    return unicodedata.normalize("NFC", str(value)).strip()
