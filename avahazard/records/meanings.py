"""What each column of docs/data_forms.md means: spellings, units, limits, what its cells hold."""

from __future__ import annotations

import math
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable
from functools import cache
from typing import Any, Literal, NamedTuple

from rapidfuzz.distance import OSA

Content = Literal["name", "text", "number", "date", "flag"]


class Limits(NamedTuple):
    """Outside `possible` a value is refused, outside `usual` it is noted; both ends count."""

    possible: tuple[float, float]
    usual: tuple[float, float]


class Meaning(NamedTuple):
    """A column in words, its `unit` if any; forms `further` keep it among what is one's own."""

    words: str
    unit: str = ""
    limits: Limits | None = None
    content: Content = "number"
    further: tuple[str, ...] = ()


ABOVE_SEA = "m a.s.l."
ELEVATION = Limits((-12_000.0, 9_000.0), (-6_000.0, 8_900.0))  # trenches and summits
ALONG = Limits((-2e6, 2e6), (-1e5, 1e5))
LENGTH = Limits((0.0, 1e6), (0.0, 1e5))
ERROR = Limits((0.0, 1e5), (0.0, 1_000.0))
# From a snowball to the largest slides of the sea floor, some 2e13 m3.
VOLUME = Limits((1e-3, 1e15), (1.0, 1e9))
# From a laboratory's chute to the sea floor, and to what falls almost freely.
HEIGHT = Limits((1e-3, 20_000.0), (1.0, 6_000.0))
REACH = Limits((1e-3, 2e6), (1.0, 1e6))
RATIO = Limits((1e-6, 1e3), (1e-3, 10.0))

MEANINGS: dict[str, Meaning] = {
    "path_id": Meaning("the path", content="name"),
    "event_id": Meaning("the event", content="name"),
    "name": Meaning("name of the path", content="text"),
    "location": Meaning("where the path is", content="text"),
    "orientation": Meaning("orientation of the path", content="text"),
    "section": Meaning("channelled or open", content="text"),
    "catchment_ha": Meaning("catchment area", "ha", Limits((0.0, 1e8), (0.0, 1e5))),
    "release_elevation_m": Meaning("elevation of the release", ABOVE_SEA, ELEVATION),
    "release_sigma_m": Meaning(
        "error of the release elevation (sd)", "m", further=("paths", "events")
    ),
    "observed_from": Meaning("first year of observation"),
    "observed_to": Meaning("last year of observation"),
    "observed_below_m": Meaning("stops above are undetected", ABOVE_SEA, ELEVATION),
    "not_observed": Meaning("years in which nobody looked", content="text", further=("paths",)),
    "width_m": Meaning("width of the flow", "m", further=("paths",)),
    "x_m": Meaning("horizontal distance from the top", "m", ALONG),
    "y_m": Meaning("elevation of the point", ABOVE_SEA, ELEVATION),
    "elevation_sigma_m": Meaning("error of the elevation (sd)", "m"),
    "land_cover": Meaning("land cover from this point on", content="text"),
    "easting_m": Meaning("easting", "m"),
    "northing_m": Meaning("northing", "m"),
    "crs": Meaning("coordinate system", content="text"),
    "lon": Meaning("longitude", "degrees"),
    "lat": Meaning("latitude", "degrees"),
    "date": Meaning("date, or year", content="date"),
    "runout_elevation_m": Meaning("elevation of the stop", ABOVE_SEA, ELEVATION),
    "runout_x_m": Meaning("horizontal distance of the stop", "m", ALONG),
    "runout_sigma_m": Meaning("error of the runout (sd)", "m", ERROR),
    "left_profile": Meaning("ran past the profile's end", content="flag"),
    "volume_m3": Meaning("volume of the deposit", "m3", VOLUME),
    "deposit_length_m": Meaning("length of the deposit", "m", LENGTH),
    "deposit_width_m": Meaning("width of the deposit", "m", LENGTH),
    "deposit_thickness_m": Meaning(
        "thickness of the deposit", "m", Limits((0.0, 5_000.0), (0.0, 100.0))
    ),
    "volume_rel_sigma": Meaning("error of log volume (sd)", "", Limits((0.0, 10.0), (0.0, 2.5))),
    "snow_type": Meaning("type of snow", content="text", further=("events",)),
    "fall_height_m": Meaning("height of fall H", "m", HEIGHT),
    "runout_length_m": Meaning("horizontal reach L", "m", REACH),
    "h_over_l": Meaning("H over L", "", RATIO),
    "elevation_m": Meaning("elevation of the speed", ABOVE_SEA, ELEVATION),
    "speed_m_s": Meaning("speed", "m/s", Limits((0.0, 500.0), (0.0, 150.0))),
    "speed_sigma_m_s": Meaning("error of the speed (sd)", "m/s", Limits((0.0, 500.0), (0.0, 50.0))),
    "return_period_years": Meaning("return period", "years"),
    "year": Meaning("year"),
}


UNITS = re.compile(r"_(?:m_s|m3|m2|m|ha)$")
SHORTEST_NEAR = 6  # letters: shorter words are too often one letter apart


def known_name(name: str) -> str | None:
    """Return the column that `name` spells in other cases, with blanks or a unit in brackets."""
    if name in MEANINGS:
        return name
    return _squashed().get(squash(name))


def near_name(name: str, columns: Iterable[str]) -> str | None:
    """Return the one of `columns` that `name` misses by a letter or by its unit, if any."""
    squashed = squash(name)
    for column in columns:
        without_unit = UNITS.sub("", column)
        if without_unit != column and squashed == squash(without_unit):
            return column
        # A letter too many, too few, another one, or two neighbours swapped.
        if len(squashed) >= SHORTEST_NEAR and OSA.distance(squashed, squash(column)) == 1:
            return column
    return None


def squash(name: str) -> str:
    """Keep letters and digits alone, in lower case; m³ is m3."""
    folded = unicodedata.normalize("NFKC", name).casefold()
    return re.sub(r"[\W_]+", "", folded)


def plain_word(text: str) -> str:
    """A value without what does not count in it: its capitals, blanks, hyphens and underscores.

    Those between letters; a single letter may be a code, and signs at an end may be grades.
    """
    found = re.sub(r"(?<=[^\W\d_])[\s_-]+(?=[^\W\d_])", " ", text.strip())
    return found.casefold() if len(found) > 1 else found


def one_spelling(texts: Iterable[str]) -> dict[str, str]:
    """The most common spelling of each text, by text; '' is none."""
    counts = Counter(text for text in texts if text)
    kept: dict[str, str] = {}
    for text in sorted(counts, key=lambda text: (-counts[text], text)):
        kept.setdefault(plain_word(text), text)
    return {text: kept[plain_word(text)] for text in counts}


@cache
def _squashed() -> dict[str, str]:
    return {squash(column): column for column in MEANINGS}


# Units that people write, by pint: what they are in those of the forms.
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
