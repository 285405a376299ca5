"""Numbers and records in words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from avahazard.results.amounts import RATIO

if TYPE_CHECKING:
    from avahazard.report.html.content import EventView

BEYOND = "beyond"
COORDINATES = {
    "elevation": "elevation",
    "x": "distance along the path",
    "length": "runout length",
    RATIO: "the ratio H/L",
    "mixed": "what was recorded",
}
"""What was recorded of a stop, in words."""
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
NARROW = "\u202f"
"""A narrow space that does not break: between thousands, and before a unit."""


def integer(value: float) -> str:
    """A whole number with its thousands apart."""
    return f"{value:,.0f}".replace(",", NARROW).replace("-", "−")


def metres(value: float | None) -> str:
    """Metres, or that the place lies beyond the profile."""
    return BEYOND if value is None else f"{integer(value)} m"


def volume(value: float | None) -> str:
    """A volume to three digits: its own error is larger."""
    return "any" if value is None else f"{integer(float(f'{value:.3g}'))} m³"


def share(value: float) -> str:
    """A share in percent, never 0 or 100 where it is not."""
    if 0.0 < value < 0.001:
        return "under 0.1 %"
    return f"{value:.1%}".replace("%", " %") if value < 0.1 else f"{value:.0%}".replace("%", " %")


def number(value: float | None) -> str:
    """Four digits where they are enough, a dash for what is not known."""
    if value is None:
        return "–"
    if value != 0 and (abs(value) < 1e-3 or abs(value) >= 1e7):
        digits, power = f"{value:.2e}".split("e")
        return f"{digits.replace('-', '−')} × 10{str(int(power)).translate(RAISED)}"
    return (integer(value) if abs(value) >= 1000 else f"{value:.4g}").replace("-", "−")


def chance(p: float, floor: float = 0.0) -> str:
    """A p-value; at its floor, 1 in n made worlds and the data themselves, as less than that."""
    if 0.0 < p <= 1.0001 * floor:
        return f"< 1/{1.0 / floor:.0f}"
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def likelier(gain: float) -> str:
    """A gain in log likelihood (nats) as how many times likelier the records are."""
    decades = gain / math.log(10.0)
    if decades < 0.0:
        return "no"
    if decades < 4.0:
        return (
            f"{integer(float(f'{10.0**decades:.2g}'))} times"
            if decades > 1.0
            else (f"{10.0**decades:.1f} times")
        )
    return f"10{str(round(decades)).translate(RAISED)} times"


def interval(spread: Mapping[str, float | None]) -> str:
    """The 5 and 95 % quantiles of a spread."""
    low, high = spread["q05"], spread["q95"]
    if low is None and high is None:
        return BEYOND
    return f"{metres(low).removesuffix(' m')} to {metres(high)}"


def unit_words(unit: str) -> str:
    """A unit as people write it."""
    return unit.replace("m3", "m³")


def axis_words(axis: str) -> str:
    """What a comparison is split by: its column's name without marks."""
    return axis.removesuffix("_m").replace("_", " ")


def count(n: int, what: str) -> str:
    """A number of things."""
    return f"{n} {what}" if n == 1 else f"{n} {what}s"


def case(row: Mapping[str, Any]) -> str:
    """What a row of bounds is for: a return period or a volume."""
    period = row["return_period_years"]
    return volume(row["volume_m3"]) if period is None else f"{period:g} years"


def volume_words(row: Mapping[str, Any]) -> str:
    """The volume of a row: given, or that of its return period."""
    period = row["return_period_years"]
    known = volume(row["volume_m3"])
    return known if period is None else f"the {period:g}-year volume ({known})"


def event_words(event: EventView, names: Mapping[str, str]) -> str:
    """The event's name, path, date and volume."""
    parts = [event.event_id]
    if event.path_id is not None:
        parts.append(names.get(event.path_id, event.path_id))
    parts.append(event.date or "undated")
    parts.append("volume unknown" if event.volume_m3 is None else volume(event.volume_m3))
    return " · ".join(parts)
