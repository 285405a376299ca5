"""Numbers that cannot be, and numbers that look like slips of units."""

from __future__ import annotations

import datetime as dt
import math
from typing import NamedTuple

from avahazard.records.errors import RowProblem
from avahazard.records.table import Table


class Range(NamedTuple):
    """Outside `possible` a value is refused, outside `usual` it is told; both ends count."""

    possible: tuple[float, float]
    usual: tuple[float, float]
    unit: str


ELEVATION = Range((-12_000.0, 9_000.0), (-6_000.0, 8_900.0), "m")  # trenches and summits
LENGTH = Range((0.0, 1e6), (0.0, 1e5), "m")
# From a snowball to the largest slides of the sea floor, some 2e13 m3.
VOLUME = Range((1e-3, 1e15), (1.0, 1e9), "m3")
RANGES: dict[str, Range] = {
    "volume_m3": VOLUME,
    "deposit_length_m": LENGTH,
    "deposit_width_m": LENGTH,
    "deposit_thickness_m": Range((0.0, 5_000.0), (0.0, 100.0), "m"),
    "volume_rel_sigma": Range((0.0, 10.0), (0.0, 2.5), ""),
    "runout_sigma_m": Range((0.0, 1e5), (0.0, 1_000.0), "m"),
    "speed_m_s": Range((0.0, 500.0), (0.0, 150.0), "m/s"),
    "speed_sigma_m_s": Range((0.0, 500.0), (0.0, 50.0), "m/s"),
    "fall_height_m": Range((0.0, 20_000.0), (0.0, 6_000.0), "m"),
    "runout_length_m": Range((0.0, 2e6), (0.0, 1e6), "m"),
    "x_m": Range((-2e6, 2e6), (-1e5, 1e5), "m"),
    "runout_x_m": Range((-2e6, 2e6), (-1e5, 1e5), "m"),
    "catchment_ha": Range((0.0, 1e8), (0.0, 1e5), "ha"),
    "y_m": ELEVATION,
    "elevation_m": ELEVATION,
    "runout_elevation_m": ELEVATION,
    "release_elevation_m": ELEVATION,
    "observed_below_m": ELEVATION,
}
YEARS = ("date", "observed_from", "observed_to")
FIRST_YEAR = 1000
SHOWN = 3


def check_ranges(
    table: Table, problems: list[RowProblem], notes: list[str], *, unusual: bool = False
) -> None:
    """Refuse what is physically impossible, and dates to come; note what is unusual, with rows.

    With `unusual` what is possible is usual: flows of another kind than snow, or of another age.
    """
    doubts: list[str] = []
    for column in table.header:
        if column in RANGES:
            _check_numbers(table, column, RANGES[column], problems, doubts)
        elif column in YEARS:
            _check_years(table, column, problems, doubts)
    if not unusual:
        notes += doubts


def _check_numbers(
    table: Table, column: str, limits: Range, problems: list[RowProblem], notes: list[str]
) -> None:
    (first, last), (low, high), unit = limits
    unusual: list[tuple[int, str]] = []
    for line, cells in table.numbered():
        if (value := _number(cells.get(column))) is None or low <= value <= high:
            continue
        if first <= value <= last:
            unusual.append((line, cells[column]))
        elif value > 0 or first < 0:  # the form refuses what is not over 0
            accepted = f"a number from {first:g} to {last:g} {unit}".rstrip()
            problems.append(RowProblem(table.file, line, column, cells[column], accepted))
    if unusual:
        notes.append(_note(table, column, unusual, f"outside {low:g} to {high:g} {unit}".rstrip()))


def _check_years(table: Table, column: str, problems: list[RowProblem], notes: list[str]) -> None:
    # A day's grace: the clock may stand in another time zone.
    tomorrow = (dt.date.today() + dt.timedelta(1)).isoformat()
    unusual: list[tuple[int, str]] = []
    for line, cells in table.numbered():
        text = cells.get(column, "")
        if len(text) not in (4, 10) or not text[:4].isdigit():
            continue
        if text > tomorrow[: len(text)]:
            accepted = "a date that is not to come"
            problems.append(RowProblem(table.file, line, column, text, accepted))
        elif int(text[:4]) < FIRST_YEAR:
            unusual.append((line, text))
    if unusual:
        notes.append(_note(table, column, unusual, f"before the year {FIRST_YEAR}"))


def _number(text: str | None) -> float | None:
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _note(table: Table, column: str, rows: list[tuple[int, str]], what: str) -> str:
    shown = ", ".join(f"line {line}: {text}" for line, text in rows[:SHOWN])
    more = f" and {len(rows) - SHOWN} more" if len(rows) > SHOWN else ""
    return (
        f"{table.file}: {column} {what} ({shown}{more}). Are the unit and the "
        "value right? If so, --unusual says it."
    )
