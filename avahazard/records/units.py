"""Units that people write, by pint: what they are in those of the forms."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Any

from avahazard.records.meanings import ABOVE_SEA

POWER = re.compile(r"(?<=[^\W\d])([23])(?![\w.])")
ABOVE_SEA_LEVEL = re.compile(
    r"(m|ft|feet)\s*(?:a\.?\s?s\.?\s?l\.?|ü\.?\s?\w+\.?|s\.?l\.?m\.?|moh\.?)", re.IGNORECASE
)
WORDS = {"pied": "ft", "pieds": "ft", "fuss": "ft", "fuß": "ft", "piedi": "ft", "fot": "ft"}
MILLIONS = re.compile(r"M(?:m3|m³|m\^3)|mio\.?\s*m3|million\s+m3", re.IGNORECASE)


def known_unit(text: str, unit: str) -> bool:
    """Whether `text` is a unit of what counts in `unit`."""
    return bool(unit) and factor(text, unit) is not None


@cache
def factor(text: str, unit: str) -> float | None:
    """How many `unit` one `text` is; None where it is no such unit, or may be two.

    Mm3 is said for a million cubic metres and is a cubic megametre: it is none.
    """
    above = ABOVE_SEA_LEVEL.fullmatch(text.strip())
    text = above.group(1) if above else text.strip()
    if MILLIONS.fullmatch(text):
        return None
    target = "m" if unit == ABOVE_SEA else unit
    try:
        found = _registry().Quantity(_spelt(text)).to(_spelt(target)).magnitude
    except Exception:  # whatever pint says of a text that is no unit
        return None
    return float(found) if isinstance(found, int | float) and 0.0 < found < math.inf else None


def _spelt(text: str) -> str:
    text = text.replace("²", "2").replace("³", "3")
    return POWER.sub(r"**\1", WORDS.get(text.casefold(), text))


@cache
def _registry() -> Any:
    from pint import UnitRegistry  # noqa: PLC0415 (slow to import)

    return UnitRegistry()
