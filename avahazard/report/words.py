"""Numbers and records in words."""

import math
import re
import tomllib
from collections.abc import Mapping
from importlib.resources import files

from avahazard.records.collection import Event
from avahazard.report.language import plural, say, spoken
from avahazard.results.base import RATIO
from avahazard.results.diagnosis import LawParameter, Shape
from avahazard.results.hazard import HazardRow, PlaceQuantiles, Spread

NAMES: dict[str, dict[str, str]] = tomllib.loads(
    (files("avahazard.report") / "words.toml").read_text("utf-8")
)
"""By what they are of, names by key."""
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
OPEN = "…"
"""An end of an interval beyond the profile, where a terminal has little room."""
SIGNIFICANT = 0.05
"""A level of a comparison with a smaller p-value is one where the model fails."""


def some(*sentences: object) -> list[str]:
    """Those sentences that there are: of each that hangs on something, `something and say(…)`."""
    return [words for words in sentences if isinstance(words, str) and words]


def coordinate_text(coordinate: str) -> str:
    """What was recorded of a stop, in words."""
    name = NAMES["coordinate"][coordinate]
    return say(name)


def digits(value: float | None, form: str) -> str | None:
    """A number in a form of Python's; None where there is none."""
    return None if value is None else spoken().number(format(value, form))


def integer(value: float) -> str:
    """A whole number with its thousands apart."""
    return spoken().number(f"{value:,.0f}")


def unit_of(coordinate: str | None) -> str:
    """The unit of scores in this coordinate of the records."""
    return "H/L" if coordinate == RATIO else "m"


def in_unit(value: float | None, coordinate: str | None, places: int = 1) -> str | None:
    """A number in the unit of the records, without it; `places` after the point of metres.

    None where there is none.
    """
    form = f".{4 if coordinate == RATIO else places}f"
    return digits(value, form)


def amount(value: float, coordinate: str | None, places: int = 1) -> str:
    """A number in the unit of the records, and the unit."""
    return f"{in_unit(value, coordinate, places)} {unit_of(coordinate)}"


def place(value: float | None) -> str:
    """Whole metres without their unit, or that the place lies beyond the profile."""
    return say("beyond") if value is None else integer(value)


def metres(value: float | None) -> str:
    """Metres, or that the place lies beyond the profile."""
    return say("beyond") if value is None else f"{integer(value)} m"


def cubic(value: float | None) -> str:
    """A volume in m3 to three digits, without its unit: its own error is larger."""
    return say("any") if value is None else integer(float(f"{value:.3g}"))


def volume(value: float | None) -> str:
    """A volume to three digits, with its unit."""
    return say("any") if value is None else f"{cubic(value)} m³"


def share(value: float) -> str:
    """A share in percent, never 0 or 100 where it is not."""
    if 0.0 < value < 0.001:
        return say("under {share}", share=spoken().number("0.1 %"))
    text = f"{value:.1%}" if value < 0.1 else f"{value:.0%}"
    return spoken().number(text.replace("%", " %"))


def number(value: float | None) -> str:
    """Four digits where they are enough, a dash for what is not known."""
    if value is None:
        return "–"
    if value != 0 and (abs(value) < 1e-3 or abs(value) >= 1e7):
        if spoken().plain:
            return f"{value:.3g}"
        digits, power = f"{value:.2e}".split("e")
        return f"{spoken().number(digits)} × 10{str(int(power)).translate(RAISED)}"
    return integer(value) if abs(value) >= 1000 else spoken().number(f"{value:.4g}")


def as_sure_as(sd: float, value: float) -> str:
    """The value with as many decimals as two digits of its standard deviation have."""
    decimals = max(1 - math.floor(math.log10(sd)) if sd > 0.0 else 0, 0)
    if decimals < 6 and abs(value) < 1e6:
        return spoken().number(f"{value:.{decimals}f}")
    return number(value)


def chance(p: float, floor: float = 0.0) -> str:
    """A p-value; at its floor, 1 in n synthetic datasets and the data themselves, as less."""
    if 0.0 < p <= 1.0001 * floor:
        return f"< 1/{1.0 / floor:.0f}"
    return spoken().number("< 0.001" if p < 0.001 else f"{p:.3f}")


def span(ends: Spread | PlaceQuantiles | tuple[float | None, float | None]) -> str:
    """From the 5 to the 95 % of a place, or between two places, in metres without the unit."""
    low, high = ends if isinstance(ends, tuple) else (ends.q05, ends.q95)
    if low is None and high is None:
        return say("beyond")
    return "–".join(OPEN if v is None and spoken().plain else place(v) for v in (low, high))


def interval(spread: Spread | PlaceQuantiles) -> str:
    """The 5 and 95 % quantiles of a spread in a sentence."""
    low, high = spread.q05, spread.q95
    if low is None and high is None:
        return say("beyond")
    return say("{low} to {high}", low=place(low), high=metres(high))


def unit_text(unit: str) -> str:
    """A unit as people write it."""
    if spoken().plain:
        return unit.replace("log friction", "log μ").replace("m3", "m³").replace(")2", ")²")
    if unit.startswith(reference := "log friction against "):
        return say("log friction against {level}", level=unit.removeprefix(reference))
    if found := re.fullmatch(r"log friction from (\S+) (?:on|to (\S+))", unit):
        year, until = (found[k] and spoken().number(found[k]) for k in (1, 2))
        if until:
            return say("log friction from {year} to {until}", year=year, until=until)
        return say("log friction from {year} on", year=year)
    known = NAMES["unit"].get(unit)
    return say(known) if known else unit.replace("m3", "m³")


def axis_text(axis: str) -> str:
    """What a comparison is split by: its column's name without marks."""
    known = NAMES["axis"].get(axis)
    return say(known) if known else axis.removesuffix("_m").replace("_", " ")


def shape_text(shape: Shape) -> tuple[str, str]:
    """What a smooth is over, with its path and unit, and of what it is."""
    unit = shape.unit.replace("degrees", "°")
    state = ", ".join(filter(None, [axis_text(shape.of), shape.path]))
    value = NAMES["shape"].get(shape.value, NAMES["shape"]["force"])
    return state + (f" ({unit})" if unit else ""), say(value)


def law_state(shape: Shape) -> str:
    """What a law is a formula of: of a volume, or of a ratio, its logarithm."""
    return f"ln {shape.of}" if shape.of.startswith("volume_m3") else shape.of


def law_unit(name: str, parameter: LawParameter, shape: Shape | None) -> str:
    """The unit of a law's parameter; of a place along the logarithm of a volume the volume."""
    if shape and law_state(shape) != shape.of and name in ("centre", "threshold", "limit"):
        there = math.exp(parameter.q50)
        return f"= ln {volume(there) if shape.of == 'volume_m3' else format(there, '.3g')}"
    return unit_text(parameter.unit)


def level_text(level: str) -> str:
    """A level of an axis: a third of its numbers by the edges, a month, or a name as it is."""
    known = NAMES["level"].get(level)
    return say(known) if known else spoken().note(level)


def events(n: int) -> str:
    """A number of events."""
    return plural("{n} event", "{n} events", n)


def paths(n: int) -> str:
    """A number of paths."""
    return plural("{n} path", "{n} paths", n)


def speeds(n: int) -> str:
    """A number of measured speeds."""
    return (
        plural("{n} measured speed", "{n} measured speeds", n) if n else say("no measured speeds")
    )


def years(period: float) -> str:
    """A return period."""
    return say("{period} years", period=spoken().number(f"{period:g}"))


def case(row: HazardRow) -> str:
    """What a row of bounds is for: a return period or a volume."""
    period = row.return_period_years
    return volume(row.volume_m3) if period is None else years(period)


def volume_text(row: HazardRow) -> str:
    """The volume of a row: given, or that of its return period."""
    known = volume(row.volume_m3)
    if row.return_period_years is None:
        return known
    period = spoken().number(f"{row.return_period_years:g}")
    return say("the {period}-year volume ({volume})", period=period, volume=known)


def event_text(event: Event, names: Mapping[str, str]) -> str:
    """The event's name, path, date and volume."""
    path = [] if event.path_id is None else [names.get(event.path_id, event.path_id)]
    date = spoken().date(event.date) if event.date else say("undated")
    known = say("volume unknown") if event.volume_m3 is None else volume(event.volume_m3)
    return " · ".join((event.event_id, *path, date, known))


def part_text(source: str) -> str:
    """A source of error as people call it."""
    if known := NAMES["part"].get(source):
        return say(known)
    return say("explained by {effect}", effect=spoken().effect(source))
