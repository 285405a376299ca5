"""Numbers and dates as people and spreadsheets write them, and what a user says of them."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

Order = Literal["dmy", "mdy"]

ISO = re.compile(r"[0-9]{4}(?:-[0-9]{2}-[0-9]{2})?")
TIMED = re.compile(r"([0-9]{4}-[0-9]{2}-[0-9]{2})[ T][0-9]{2}:[0-9]{2}.*")
YEAR_FIRST = re.compile(r"([0-9]{4})[./]([0-9]{1,2})[./]([0-9]{1,2})")
COMPACT = re.compile(r"([0-9]{4})([0-9]{2})([0-9]{2})")
DOTTED = re.compile(r"([0-9]{1,2})\. ?([0-9]{1,2})\. ?([0-9]{4})")
SLASHED = re.compile(r"([0-9]{1,2})[/-]([0-9]{1,2})[/-]([0-9]{4})")
SERIAL = re.compile(r"([0-9]{5})(?:\.[0-9]+)?")
FIRST_DAY = dt.date(1899, 12, 30)  # day 0 of Excel, for days after February 1900

ACCEPTED = "a date as 1950-02-13, or a year as 1950"
AMBIGUOUS = f"{ACCEPTED}: day or month first? Say --dates dmy or --dates mdy"
MIXED = "dates with the day first or the month first, one of them in a column; or 1950-02-13"
BESIDE_DAYS = f"{ACCEPTED}: beside Excel's day numbers this may be a year or a day"


def read_dates(
    texts: Sequence[str], order: Order | None, first_day: dt.date = FIRST_DAY
) -> tuple[list[str], list[tuple[int, str]], str]:
    """Return `texts` `[n]` as ISO dates, what is wrong, and how they were read.

    Faults are `(place, what is accepted)`; what is no date at all stays as it is, for the form
    to refuse. Whether the day or the month comes first is decided by the column, unless `order`
    says it. Day numbers of a spreadsheet count from `first_day`.
    """
    different = set(texts)
    if all(ISO.fullmatch(text) for text in different):
        return list(texts), [], ""
    dates, words = list(texts), dict[str, None]()
    faults: list[tuple[int, str]] = []
    slashed: list[tuple[int, int, int, int]] = []
    serial = any(map(SERIAL.fullmatch, different))
    for k, text in enumerate(texts):
        if ISO.fullmatch(text):
            if serial and len(text) == 4:
                faults.append((k, BESIDE_DAYS))
        elif found := TIMED.fullmatch(text):
            dates[k] = found.group(1)
            words["their time of day left out"] = None
        elif found := YEAR_FIRST.fullmatch(text) or COMPACT.fullmatch(text):
            year, month, day = map(int, found.groups())
            _put(dates, k, year, month, day, faults)
            words["the year first"] = None
        elif found := DOTTED.fullmatch(text):
            day, month, year = map(int, found.groups())
            _put(dates, k, year, month, day, faults)
            words["dd.mm.yyyy"] = None
        elif found := SLASHED.fullmatch(text):
            first, second, year = map(int, found.groups())
            slashed.append((k, first, second, year))
        elif found := SERIAL.fullmatch(text):
            dates[k] = (first_day + dt.timedelta(int(found.group(1)))).isoformat()
            words["day numbers of Excel"] = None
    if slashed:
        words[_by_order(dates, slashed, order, faults)] = None
    if not words:
        return dates, faults, ""
    pairs = zip(texts, dates, strict=True)
    example = next((f" ({text} is {date})" for text, date in pairs if text != date), "")
    return dates, faults, f"dates: {', '.join(words)}{example}"


def _by_order(
    dates: list[str],
    slashed: Sequence[tuple[int, int, int, int]],
    order: Order | None,
    faults: list[tuple[int, str]],
) -> str:
    """Read `(place, first, second, year)`; a first number over 12 is a day, a second one too."""
    day_first = [k for k, first, _, _ in slashed if first > 12]
    month_first = [k for k, _, second, _ in slashed if second > 12]
    if day_first and month_first and order is None:
        rarer = min(day_first, month_first, key=len)
        faults += [(k, MIXED) for k in rarer]
    elif order is None and not day_first and not month_first:
        faults += [(k, AMBIGUOUS) for k, first, second, _ in slashed if first != second]
    chosen = order or ("mdy" if len(month_first) > len(day_first) else "dmy")
    faulty = {k for k, _ in faults}
    for k, first, second, year in slashed:
        day, month = (first, second) if chosen == "dmy" else (second, first)
        if k not in faulty:
            _put(dates, k, year, month, day, faults)
    return "the day first" if chosen == "dmy" else "the month first"


def _put(
    dates: list[str], k: int, year: int, month: int, day: int, faults: list[tuple[int, str]]
) -> None:
    try:
        dates[k] = dt.date(year, month, day).isoformat()
    except ValueError:
        faults.append((k, ACCEPTED))


Decimal = Literal["point", "comma"]

BLANKS = " \u00a0\u2009\u202f"
APOSTROPHES = "'’"
SIGN = "[+\\-\u2212]?"
EXPONENT = r"(?:[eE][+-]?[0-9]+)?"


def _pattern(decimal: str, group: str) -> re.Pattern[str]:
    grouped = (
        rf"[1-9][0-9]{{0,2}}(?P<g>[{group}{BLANKS}{APOSTROPHES}])[0-9]{{3}}(?:(?P=g)[0-9]{{3}})*"
    )
    whole = rf"(?:{grouped}|[0-9]+)(?:{decimal}[0-9]*)?"
    return re.compile(rf"{SIGN}(?:{whole}|{decimal}[0-9]+){EXPONENT}")


PATTERNS = {"point": _pattern(r"\.", ","), "comma": _pattern(",", r"\.")}
SIGNS = {"point": ".", "comma": ","}
PLAIN = re.compile(r"[+-]?[0-9]+")


def canonical(text: str, decimal: Decimal) -> str | None:
    """Return the number `text` with a decimal point and no groups; None if it is none.

    `1 234,5` is 1234.5 by a comma, `1,234.5` by a point; groups have three digits each.
    """
    if not PATTERNS[decimal].fullmatch(text):
        return None
    digits = re.sub(rf"[{BLANKS}{APOSTROPHES}]", "", text).replace("\u2212", "-")
    sign = SIGNS[decimal]
    return digits.replace("," if sign == "." else ".", "").replace(sign, ".")


@dataclass
class DecimalMarks:
    """Where the numbers of a file can only be read with a point, only with a comma, or with both.

    Places are those that were given with the texts; `ambiguous` ones are such as 1,234.
    """

    point: list[int] = field(default_factory=list)
    comma: list[int] = field(default_factory=list)
    ambiguous: list[int] = field(default_factory=list)


def weigh(texts: Sequence[str]) -> DecimalMarks:
    """Sort `texts` `[n]` by what they say of the decimal sign; integers and words say nothing."""
    found = DecimalMarks()
    for k, text in enumerate(texts):
        if PLAIN.fullmatch(text):
            continue
        point, comma = canonical(text, "point"), canonical(text, "comma")
        if point == comma:
            continue
        if comma is None:
            found.point.append(k)
        elif point is None:
            found.comma.append(k)
        else:
            found.ambiguous.append(k)
    return found


def is_number(text: str) -> bool:
    """Tell whether `text` is a number by one of the signs."""
    return any(pattern.fullmatch(text) for pattern in PATTERNS.values())


@dataclass(frozen=True, slots=True)
class Conventions:
    """The decimal sign, and whether day or month comes first; None: the file shows it.

    `unusual`: numbers beyond those of snow avalanches are meant so, and need no note.
    """

    decimal: Decimal | None = None
    dates: Order | None = None
    unusual: bool = False


UNKNOWN = Conventions()
