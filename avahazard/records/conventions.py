"""Numbers and dates as people and spreadsheets write them, and what a user says of them."""

import datetime as dt
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

Order = Literal["dmy", "mdy"]
YearMonthDay = tuple[int, int, int]  # day 0: there is none

ISO = re.compile(r"[0-9]{4}(?:-[0-9]{2}-[0-9]{2})?")
SLASHED = re.compile(r"([0-9]{1,2})[/-]([0-9]{1,2})[/-]([0-9]{4})")
WINTER = re.compile(r"([0-9]{4}) ?[/-] ?([0-9]{4}|[0-9]{2})")
SERIAL = re.compile(r"([0-9]{5})(?:\.[0-9]+)?")
NAME, YEAR, TWO, UP_TO_TWO = r"([^\W\d_]+)\.?", "([0-9]{4})", "([0-9]{2})", "([0-9]{1,2})"
BY_NAME, WITH_TIME = "months by name", "their time of day left out"
FORMS = tuple(  # pattern, the groups of year, month and day, words
    (re.compile(pattern), groups, words)
    for pattern, groups, words in (
        (rf"{YEAR}-{TWO}-{TWO}[ T][0-9]{{2}}:[0-9]{{2}}.*", (1, 2, 3), WITH_TIME),
        (rf"{YEAR}[./]{UP_TO_TWO}[./]{UP_TO_TWO}", (1, 2, 3), "the year first"),
        (rf"{YEAR}{TWO}{TWO}", (1, 2, 3), "the year first"),
        (rf"{UP_TO_TWO}\. ?{UP_TO_TWO}\. ?{YEAR}", (3, 2, 1), "dd.mm.yyyy"),
        (rf"{UP_TO_TWO}(?:st|nd|rd|th|er|\.)?[ -]?{NAME}[ -]{YEAR}", (3, 2, 1), BY_NAME),
        (rf"{NAME} {UP_TO_TWO}(?:st|nd|rd|th)?,? {YEAR}", (3, 1, 2), BY_NAME),
        (rf"{NAME}[ -]{YEAR}", (2, 1), BY_NAME),
    )
)
TWO_SIGNS = re.compile(r"[0-9].*[-/. ].*[0-9].*[-/. ]")
FIRST_DAY = dt.date(1899, 12, 30)  # day 0 of Excel, for days after February 1900
WINTER_BEGINS = 10  # October
LANGUAGES = ("en", "de", "de_AT", "fr", "it", "nb")

ACCEPTED = "a date as 1950-02-13, or a year as 1950"
NO_SUCH_DAY = f"{ACCEPTED}: this day does not exist"
AMBIGUOUS = (
    f"{ACCEPTED}: day or month first? Write "
    'dates = "dmy" (or "mdy") in a columns.toml beside the file, or import with --dates dmy'
)
MIXED = "dates with the day first or the month first, one of them in a column; or 1950-02-13"
BESIDE_DAYS = f"{ACCEPTED}: beside Excel's day numbers this may be a year or a day"
BESIDE_DATES = f"{ACCEPTED}: a day number of a spreadsheet beside written dates is an error"
WITHOUT_DAY = "months without a day as the year in which their winter ends"
MONTH_OR_WINTER = f"{ACCEPTED}: a month or a winter? Write a winter as 2004/2005"


def read_dates(
    texts: Sequence[str], order: Order | None, first_day: dt.date = FIRST_DAY
) -> tuple[list[str], list[tuple[int, str]], str]:
    """Return `texts` `[n]` as ISO dates, what is wrong, and how they were read.

    Faults are `(place, what is accepted)`; what is no date at all stays as it is, for the form
    to refuse. Whether the day or the month comes first is decided by the column, unless `order`
    says it. Day numbers of a spreadsheet count from `first_day`. A winter, and a month without
    its day, become the year in which their winter ends.
    """
    if all(ISO.fullmatch(text) for text in set(texts)):
        return list(texts), [], ""
    words = dict[str, None]()
    found: dict[int, YearMonthDay] = {}
    slashed: dict[int, tuple[int, int, int]] = {}
    pairs: dict[int, tuple[int, int]] = {}
    serial = [k for k, text in enumerate(texts) if SERIAL.fullmatch(text)]
    written = [k for k, text in enumerate(texts) if TWO_SIGNS.search(text)]
    faults = [(k, BESIDE_DATES) for k in min(serial, written, key=len)]
    faulty = {k for k, _ in faults}
    for k, text in enumerate(texts):
        if k in faulty:
            continue
        if ISO.fullmatch(text):
            if serial and len(text) == 4:
                faults.append((k, BESIDE_DAYS))
        elif parts := SLASHED.fullmatch(text):
            first, second, year = map(int, parts.groups())
            slashed[k] = first, second, year
        elif parts := WINTER.fullmatch(text):
            pairs[k] = int(parts.group(1)), int(parts.group(2))
        elif named := _year_month_day(text, first_day):
            found[k], said = named
            words[said] = None
    if slashed:
        words[_by_order(found, slashed, order, faults)] = None
    words |= dict.fromkeys(_winters(found, pairs, faults))
    dates = list(texts)
    for k, (year, month, day) in found.items():
        try:
            # A month without its day is kept as its winter.
            winter = str(year + (month >= WINTER_BEGINS))
            dates[k] = dt.date(year, month, day).isoformat() if day else winter
        except ValueError:
            faults.append((k, NO_SUCH_DAY))
    if not words:
        return dates, faults, ""
    both = zip(texts, dates, strict=True)
    example = next((f" ({text} is {date})" for text, date in both if text != date), "")
    return dates, faults, f"dates: {', '.join(words)}{example}"


def _year_month_day(text: str, first_day: dt.date) -> tuple[YearMonthDay, str] | None:
    """The parts of a text that can only be read in one way, and the words for it."""
    if serial := SERIAL.fullmatch(text):
        date = first_day + dt.timedelta(int(serial.group(1)))
        return (date.year, date.month, date.day), "day numbers of Excel"
    for pattern, (year, month, *day), words in FORMS:
        if found := pattern.fullmatch(text):
            name = found.group(month)
            number = int(name) if name.isdigit() else _month_names().get(name.casefold())
            if number is not None:
                days = int(found.group(day[0])) if day else 0
                return (int(found.group(year)), number, days), words if day else WITHOUT_DAY
    return None


@cache
def _month_names() -> dict[str, int]:
    """The names of the months and their abbreviations, where all languages agree on them."""
    from babel.dates import get_month_names  # noqa: PLC0415 (slow to import)

    found: dict[str, set[int]] = {"sept": {9}}
    for language in LANGUAGES:
        for width in ("wide", "abbreviated"):
            for month, name in get_month_names(width, "format", language).items():
                found.setdefault(name.strip(".").casefold(), set()).add(month)
    return {name: min(months) for name, months in found.items() if len(months) == 1}


def _winters(
    found: dict[int, YearMonthDay], pairs: dict[int, tuple[int, int]], faults: list[tuple[int, str]]
) -> Iterator[str]:
    """Read a year and the next as a winter, else as a month; 2004-05 as the rest of the column."""
    winters = {k for k, (year, rest) in pairs.items() if rest in (year + 1, (year + 1) % 100)}
    months = {k for k, (_, rest) in pairs.items() if 1 <= rest <= 12}
    both = winters & months
    as_winters, as_months = bool(winters - both), bool(months - both)
    for k, (year, rest) in pairs.items():
        if k in both and as_winters == as_months:
            faults.append((k, MONTH_OR_WINTER))
        elif k in winters and (k not in both or as_winters):
            found[k] = year + 1, 1, 0
            yield "winters as the year in which they end"
        elif k in months:
            found[k] = year, rest, 0
            yield WITHOUT_DAY


def _by_order(
    found: dict[int, YearMonthDay],
    slashed: Mapping[int, tuple[int, int, int]],
    order: Order | None,
    faults: list[tuple[int, str]],
) -> str:
    """Read first, second and year; a first number over 12 is a day, a second one too."""
    day_first = [k for k, (first, _, _) in slashed.items() if first > 12]
    month_first = [k for k, (_, second, _) in slashed.items() if second > 12]
    if day_first and month_first and order is None:
        faults += [(k, MIXED) for k in min(day_first, month_first, key=len)]
    elif order is None and not day_first and not month_first:
        faults += [(k, AMBIGUOUS) for k, (one, other, _) in slashed.items() if one != other]
    chosen = order or ("mdy" if len(month_first) > len(day_first) else "dmy")
    faulty = {k for k, _ in faults}
    for k, (first, second, year) in slashed.items():
        if k not in faulty:
            found[k] = (year, second, first) if chosen == "dmy" else (year, first, second)
    return "the day first" if chosen == "dmy" else "the month first"


WINDS = (
    "N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE",
    "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW",
)  # fmt: skip
POINTS = ("NESW", "NOSW", "NESO", "NØSV", "NÖSV")
"""North, east, south and west by their letters in several languages: O is east or west."""
CAPITALS = re.compile(f"[{''.join(POINTS)}]{{1,3}}")


def read_directions(texts: Collection[str]) -> dict[str, str]:
    """Those of `texts` that are directions, each as one of `WINDS`.

    The letters of all of them decide on the language; where several are possible, only what is the
    same in each is read.
    """
    capitals = {text for text in texts if CAPITALS.fullmatch(text)}
    letters = set("".join(capitals))
    languages = [str.maketrans(p, "NESW") for p in POINTS if letters.issubset(p)]
    meant = {text: {text.translate(language) for language in languages} for text in capitals}
    read = {text: text.upper() for text in texts} | {
        t: min(m) for t, m in meant.items() if len(m) == 1
    }
    return {text: wind for text, wind in read.items() if wind in WINDS}


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


def canonical(text: str, decimal: Decimal) -> str | None:
    """The number `text` with a decimal point, no groups (of three digits); None if it is none."""
    if not PATTERNS[decimal].fullmatch(text):
        return None
    digits = re.sub(rf"[{BLANKS}{APOSTROPHES}]", "", text).replace("\u2212", "-")
    group, sign = ",." if decimal == "point" else ".,"
    return digits.replace(group, "").replace(sign, ".")


def is_number(text: str) -> bool:
    """Tell whether `text` is a number by one of the signs."""
    return any(pattern.fullmatch(text) for pattern in PATTERNS.values())


@dataclass(frozen=True, slots=True)
class Conventions:
    """The decimal sign, and whether day or month comes first; None: the file shows it.

    `unusual`: numbers beyond those of snow avalanches are intended, and need no note. Cells that
    hold one of the marks `unknown` are empty.
    """

    decimal: Decimal | None = None
    dates: Order | None = None
    unusual: bool = False
    unknown: tuple[str, ...] = ()

    def is_unknown(self, text: str) -> bool:
        """Tell whether a cell holds a mark of unknown, numbers by their value."""
        return _by_value(text) in map(_by_value, self.unknown)


def _by_value(text: str) -> str | float:
    number = canonical(text, "point")
    return text.casefold() if number is None else float(number)


UNKNOWN = Conventions()
