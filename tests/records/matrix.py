"""One set of events written in every way that people and spreadsheets write them."""

from __future__ import annotations

import csv
import datetime as dt
import io
from pathlib import Path
from typing import Any

from openpyxl import Workbook

HEADER = ("event_id", "path_id", "date", "runout_x_m", "volume_m3", "slope", "snow_type")
DAYS = (dt.date(1950, 1, 14), dt.date(1999, 2, 23), dt.date(1985, 12, 31))
ROWS = (
    ("a", "Aisté", DAYS[0], 310.5, 52000.0, 0.25, "dry"),
    ("b", "Aisté", DAYS[1], 1234.567, 1234567.0, -1.5, "très dur"),
    ("c", "Aisté", DAYS[2], 400.0, 8000.0, 12.0, "dry"),
)

DATES = {
    "iso": "{0:%Y-%m-%d}",
    "timed": "{0:%Y-%m-%d} 00:00:00",
    "dotted": "{0:%d.%m.%Y}",
    "short": "{0.day}.{0.month}.{0.year}",
    "day": "{0:%d/%m/%Y}",
    "month": "{0:%m/%d/%Y}",
    "compact": "{0:%Y%m%d}",
    "serial": "serial",
}
NUMBERS = ("point", "comma", "point grouped", "comma grouped", "swiss", "french")
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252")
SEPARATORS = (",", ";", "\t")


def date_text(day: dt.date, form: str) -> str:
    """Write `day` in one of `DATES`."""
    if form == "serial":
        return str((day - dt.date(1899, 12, 30)).days)
    return DATES[form].format(day)


def number_text(value: float, form: str) -> str:
    """Write `value` in one of `NUMBERS`."""
    grouped = f"{value:,}" if form in NUMBERS[2:] else f"{value}"
    grouped = grouped.removesuffix(".0")
    swap = {
        "comma": str.maketrans(".", ","),
        "comma grouped": str.maketrans(".,", ",."),
        "swiss": str.maketrans(",", "’"),
        "french": str.maketrans(".,", ",\u00a0"),
    }
    return grouped.translate(swap.get(form, {}))


def as_text(separator: str, numbers: str, dates: str, encoding: str) -> bytes:
    """Return the events as a text file."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, delimiter=separator)
    writer.writerow(HEADER)
    for name, path, day, *values, snow in ROWS:
        texts = [number_text(value, numbers) for value in values]
        writer.writerow((name, path, date_text(day, dates), *texts, snow))
    return out.getvalue().encode(encoding)


def save_workbook(file: Path, sheets: dict[str, list[tuple[Any, ...]]], mac: bool = False) -> Path:
    """Write a workbook of these rows by sheet; with `mac` its days count from 1904."""
    book = Workbook()
    if mac:
        book.epoch = dt.datetime(1904, 1, 1)
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    book.save(file)
    return file
