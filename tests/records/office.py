"""One table as offices write it: title, row of units, merged cells, languages, marks, dates."""

from __future__ import annotations

import csv
import datetime as dt
import io
import zipfile
from pathlib import Path
from typing import Any, NamedTuple
from xml.sax.saxutils import escape

from openpyxl import Workbook

NAMES = {
    "en": ("Record", "Path", "Date", "Stop elevation", "Volume"),
    "de": ("Lawinen-Nr", "Lawinenzug", "Datum", "Auslaufhöhe", "Volumen"),
    "fr": ("No avalanche", "Couloir", "Date", "Altitude d'arrêt", "Volume du dépôt"),
    "it": ("Codice", "Percorso", "Data", "Quota arresto", "Volume deposito"),
    "no": ("Skrednr", "Skredbane", "Dato", "Stopphøyde", "Skredvolum"),
}
UNITS = ("", "", "", "m", "m3")
COLUMNS = ("event_id", "path_id", "date", "runout_elevation_m", "volume_m3")
TITLES = {"en": "Avalanches", "de": "Lawinen", "fr": "Avalanches", "it": "Valanghe", "no": "Skred"}
DAYS = (dt.date(1999, 2, 23), dt.date(2001, 12, 4), dt.date(2004, 3, 17), dt.date(2010, 1, 8))
EVENTS = (
    ("a1", "Pra", DAYS[0], 1700.0, 5000.0),
    ("a2", "Pra", DAYS[1], 1650.0, None),
    ("a3", "Bois", DAYS[2], 1720.5, 12500.0),
    ("a4", "Bois", DAYS[3], 1800.0, 800.0),
)
DATES = ("cell", "%d.%m.%Y", "%Y-%m-%d")
MARKS = ("", "?", "NULL", "-9999")
FORMATS = ("xlsx", "xls", "ods", "csv")


class Office(NamedTuple):
    """How a table is written."""

    title: bool
    units: bool
    merged: bool
    language: str
    mark: str
    dates: str
    format: str

    @property
    def header(self) -> int:
        """The row of the header, from 1."""
        return 3 if self.title else 1


def grid(office: Office) -> tuple[list[list[Any]], list[tuple[int, int]]]:
    """The rows, and the pairs of rows (from 0) whose second column is one merged cell."""
    rows: list[list[Any]] = []
    if office.title:
        rows += [[TITLES[office.language], None, None, None, None], [None] * 5]
    rows.append(list(NAMES[office.language]))
    if office.units:
        rows.append([unit or None for unit in UNITS])
    first = len(rows)
    for name, path, day, stop, volume in EVENTS:
        date = day if office.dates == "cell" else day.strftime(office.dates)
        rows.append([name, path, date, stop, volume if volume else (office.mark or None)])
    merged = []
    if office.merged:
        merged = [(first, first + 1), (first + 2, first + 3)]
        rows[first + 1][1] = rows[first + 3][1] = None
    return rows, merged


def write(file: Path, office: Office) -> None:
    """Write the table in its format."""
    rows, merged = grid(office)
    {"xlsx": _xlsx, "xls": _xls, "ods": _ods, "csv": _csv}[office.format](file, rows, merged)


def _xlsx(file: Path, rows: list[list[Any]], merged: list[tuple[int, int]]) -> None:
    book = Workbook()
    sheet = book.worksheets[0]
    for row in rows:
        sheet.append(row)
    for top, bottom in merged:
        sheet.merge_cells(start_row=top + 1, end_row=bottom + 1, start_column=2, end_column=2)
    book.save(file)


def _xls(file: Path, rows: list[list[Any]], merged: list[tuple[int, int]]) -> None:
    import xlwt  # noqa: PLC0415 (of this format alone)

    book = xlwt.Workbook()
    sheet, day = book.add_sheet("Sheet"), xlwt.easyxf(num_format_str="DD.MM.YYYY")
    covered = {(k, 1) for top, bottom in merged for k in range(top, bottom + 1)}
    for k, row in enumerate(rows):
        for j, value in enumerate(row):
            if value is not None and (k, j) not in covered:
                sheet.write(k, j, value, *([day] if isinstance(value, dt.date) else []))
    for top, bottom in merged:
        sheet.write_merge(top, bottom, 1, 1, rows[top][1])
    book.save(str(file))


def _ods(file: Path, rows: list[list[Any]], merged: list[tuple[int, int]]) -> None:
    spans = dict(merged)

    def cell(k: int, j: int, value: Any) -> str:
        span = f' table:number-rows-spanned="{spans[k] - k + 1}"' if j == 1 and k in spans else ""
        if value is None:
            return f"<table:table-cell{span}/>"
        if isinstance(value, dt.date):
            typed = f'office:value-type="date" office:date-value="{value.isoformat()}"'
        elif isinstance(value, float):
            typed = f'office:value-type="float" office:value="{value}"'
        else:
            typed = 'office:value-type="string"'
        text = f"<text:p>{escape(str(value))}</text:p>"
        return f"<table:table-cell {typed}{span}>{text}</table:table-cell>"

    body = "".join(
        f"<table:table-row>{''.join(cell(k, j, v) for j, v in enumerate(row))}</table:table-row>"
        for k, row in enumerate(rows)
    )
    spaces = " ".join(
        f'xmlns:{name}="urn:oasis:names:tc:opendocument:xmlns:{name}:1.0"'
        for name in ("office", "table", "text")
    )
    content = (
        f'<?xml version="1.0"?><office:document-content {spaces} office:version="1.2"><office:body>'
        f'<office:spreadsheet><table:table table:name="Sheet">{body}</table:table>'
        "</office:spreadsheet></office:body></office:document-content>"
    )
    manifest = (
        '<?xml version="1.0"?><manifest:manifest '
        'xmlns:manifest="urn:oasis:names:tc:opendocument:xmlns:manifest:1.0"/>'
    )
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", content)
        archive.writestr("META-INF/manifest.xml", manifest)


def _csv(file: Path, rows: list[list[Any]], _merged: list[tuple[int, int]]) -> None:
    out = io.StringIO(newline="")
    csv.writer(out, delimiter=";").writerows([["" if v is None else v for v in r] for r in rows])
    file.write_text(out.getvalue(), encoding="utf-8")
