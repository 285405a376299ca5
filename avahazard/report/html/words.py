"""Numbers and records in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from avahazard.report.language import ENGLISH, NARROW, Language
from avahazard.results.base import RATIO, bare, unit_of

if TYPE_CHECKING:
    from avahazard.report.html.content import EventView

__all__ = ["NARROW"]

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def coordinate_words(coordinate: str, language: Language = ENGLISH) -> str:
    """What was recorded of a stop, in words."""
    say = language.say
    return {
        "elevation": say("elevation"),
        "x": say("distance along the path"),
        "length": say("runout length"),
        RATIO: say("the ratio H/L"),
        "mixed": say("what was recorded"),
    }[coordinate]


def integer(value: float, language: Language = ENGLISH) -> str:
    """A whole number with its thousands apart."""
    return language.number(f"{value:,.0f}")


def amount(
    value: float, coordinate: str | None, digits: int = 1, language: Language = ENGLISH
) -> str:
    """A number in the unit of the records, and the unit."""
    return language.number(f"{bare(value, coordinate, digits)} {unit_of(coordinate)}")


def beyond(language: Language = ENGLISH) -> str:
    """That a place lies past the end of the profile."""
    return language.say("beyond")


def metres(value: float | None, language: Language = ENGLISH) -> str:
    """Metres, or that the place lies beyond the profile."""
    return beyond(language) if value is None else f"{integer(value, language)} m"


def volume(value: float | None, language: Language = ENGLISH) -> str:
    """A volume to three digits: its own error is larger."""
    if value is None:
        return language.say("any")
    return f"{integer(float(f'{value:.3g}'), language)} m³"


def share(value: float, language: Language = ENGLISH) -> str:
    """A share in percent, never 0 or 100 where it is not."""
    if 0.0 < value < 0.001:
        return language.say("under {share}", share=language.number("0.1 %"))
    text = f"{value:.1%}" if value < 0.1 else f"{value:.0%}"
    return language.number(text.replace("%", " %"))


def number(value: float | None, language: Language = ENGLISH) -> str:
    """Four digits where they are enough, a dash for what is not known."""
    if value is None:
        return "–"
    if value != 0 and (abs(value) < 1e-3 or abs(value) >= 1e7):
        digits, power = f"{value:.2e}".split("e")
        return f"{language.number(digits)} × 10{str(int(power)).translate(RAISED)}"
    return integer(value, language) if abs(value) >= 1000 else language.number(f"{value:.4g}")


def chance(p: float, floor: float = 0.0, language: Language = ENGLISH) -> str:
    """A p-value; at its floor, 1 in n made worlds and the data themselves, as less than that."""
    if 0.0 < p <= 1.0001 * floor:
        return f"< 1/{1.0 / floor:.0f}"
    return language.number("< 0.001" if p < 0.001 else f"{p:.3f}")


def likelier(gain: float, language: Language = ENGLISH) -> str:
    """A gain in log likelihood (nats) as how many times likelier the records are."""
    decades = gain / math.log(10.0)
    if decades < 0.0:
        return language.say("no")
    if decades >= 4.0:
        times = f"10{str(round(decades)).translate(RAISED)}"
    elif decades > 1.0:
        times = integer(float(f"{10.0**decades:.2g}"), language)
    else:
        times = language.number(f"{10.0**decades:.1f}")
    return language.say("{number} times", number=times)


def interval(spread: Mapping[str, float | None], language: Language = ENGLISH) -> str:
    """The 5 and 95 % quantiles of a spread."""
    low, high = spread["q05"], spread["q95"]
    if low is None and high is None:
        return beyond(language)
    return between(metres(low, language).removesuffix(" m"), metres(high, language), language)


def mirrored(z: Mapping[str, float | None]) -> dict[str, float | None]:
    """Quantiles of elevation in the order of x: the far end is the low one."""
    return {"q05": z["q95"], "q95": z["q05"]}


def between(low: str, high: str, language: Language = ENGLISH) -> str:
    """From the one to the other."""
    return language.say("{low} to {high}", low=low, high=high)


def unit_words(unit: str, language: Language = ENGLISH) -> str:
    """A unit as people write it."""
    say = language.say
    reference = "log friction against "
    if unit.startswith(reference):
        return say("log friction against {level}", level=unit.removeprefix(reference))
    known = {
        "log friction": say("log friction"),
        "log friction per 1000 m": say("log friction per 1000 m"),
        "log friction per 60 days": say("log friction per 60 days"),
        "log friction per (60 days)2": say("log friction per (60 days)²"),
        "log of the factor": say("log of the factor"),
        "of the deposit length": say("of the deposit length"),
        "year": say("year"),
    }
    return known.get(unit, unit.replace("m3", "m³"))


def axis_words(axis: str, language: Language = ENGLISH) -> str:
    """What a comparison is split by: its column's name without marks."""
    say = language.say
    known = {
        "path": say("path"),
        "volume": say("volume"),
        "year": say("year"),
        "month": say("month"),
        "orientation": say("orientation"),
        "snow_type": say("snow type"),
        "section": say("section"),
        "release_elevation_m": say("release elevation"),
        "predicted_stop_elevation_m": say("predicted stop elevation"),
        "slope_at_predicted_stop": say("slope at predicted stop"),
        "land_cover_at_predicted_stop": say("land cover at predicted stop"),
        "place_along_path": say("place along path"),
        "predicted_speed_m_s": say("predicted speed"),
    }
    return known.get(axis, axis.removesuffix("_m").replace("_", " "))


def level_words(level: str, language: Language = ENGLISH) -> str:
    """A level of an axis: a third of its numbers by the edges, a month, or a name as it is."""
    say = language.say
    known = {"channelled": say("channelled"), "open": say("open"), "forest": say("forest")}
    return known.get(level) or language.note(level)


def listed(names: Sequence[str], language: Language = ENGLISH) -> str:
    """Names in a row, as a sentence has them."""
    if len(names) < 2:
        return "".join(names)
    return language.say("{some} and {last}", some=", ".join(names[:-1]), last=names[-1])


def kept_back(by: str, language: Language = ENGLISH) -> str:
    """On what a held-out error is."""
    say = language.say
    return say("on paths kept back") if by == "path" else say("on events kept back")


def of_coordinate(error: str, coordinate: str, language: Language = ENGLISH) -> str:
    """An error, and in which coordinate it is."""
    of = coordinate_words(coordinate, language)
    return language.say("{error} of {coordinate}", error=error, coordinate=of)


def events(n: int, language: Language = ENGLISH) -> str:
    """A number of events."""
    return language.plural("{n} event", "{n} events", n)


def paths(n: int, language: Language = ENGLISH) -> str:
    """A number of paths."""
    return language.plural("{n} path", "{n} paths", n)


def years(period: float, language: Language = ENGLISH) -> str:
    """A return period."""
    return language.say("{period} years", period=language.number(f"{period:g}"))


def case(row: Mapping[str, Any], language: Language = ENGLISH) -> str:
    """What a row of bounds is for: a return period or a volume."""
    period = row["return_period_years"]
    return volume(row["volume_m3"], language) if period is None else years(period, language)


def volume_words(row: Mapping[str, Any], language: Language = ENGLISH) -> str:
    """The volume of a row: given, or that of its return period."""
    period = row["return_period_years"]
    known = volume(row["volume_m3"], language)
    if period is None:
        return known
    return language.say(
        "the {period}-year volume ({volume})",
        period=language.number(f"{period:g}"),
        volume=known,
    )


def event_words(event: EventView, names: Mapping[str, str], language: Language = ENGLISH) -> str:
    """The event's name, path, date and volume."""
    parts = [event.event_id]
    if event.path_id is not None:
        parts.append(names.get(event.path_id, event.path_id))
    parts.append(language.date(event.date) if event.date else language.say("undated"))
    parts.append(
        language.say("volume unknown")
        if event.volume_m3 is None
        else volume(event.volume_m3, language)
    )
    return " · ".join(parts)
