"""Numbers as people write them, with decimal points or commas and groups of thousands."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

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
class Evidence:
    """Where the numbers of a file can only be read with a point, only with a comma, or with both.

    Places are those that were given with the texts; `ambiguous` ones are such as 1,234.
    """

    point: list[int] = field(default_factory=list)
    comma: list[int] = field(default_factory=list)
    ambiguous: list[int] = field(default_factory=list)


def weigh(texts: Sequence[str]) -> Evidence:
    """Sort `texts` `[n]` by what they say of the decimal sign; integers and words say nothing."""
    found = Evidence()
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
