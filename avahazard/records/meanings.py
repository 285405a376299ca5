"""What each column of docs/data_forms.md means: spellings, units, limits, what its cells hold."""

import math
import re
import tomllib
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from rapidfuzz.distance import OSA

Content = Literal["name", "text", "number", "date", "flag", "choice"]


EVERY = (-math.inf, math.inf)


class Meaning(NamedTuple):
    """A column in words, its `unit` if any; forms `further` keep it among what is one's own.

    Outside `possible` a value is refused, outside `usual` it is noted; both ends count. `values`
    are those of a choice, or known among others, each with words for it in several languages.
    """

    words: str
    unit: str = ""
    possible: tuple[float, float] = EVERY
    usual: tuple[float, float] = EVERY
    content: Content = "number"
    further: Sequence[str] = ()
    values: Mapping[str, Sequence[str]] = MappingProxyType({})


ABOVE_SEA = "m a.s.l."
_COLUMNS = tomllib.loads((files("avahazard.records") / "columns.toml").read_text("utf-8"))
MEANINGS: dict[str, Meaning] = {
    name: Meaning(**{field: told[field] for field in Meaning._fields if field in told})
    for name, told in _COLUMNS.items()
    if "words" in told
}
NAMES: dict[str, list[str]] = {n: told["names"] for n, told in _COLUMNS.items() if "names" in told}
"""Words for columns in several languages, by which a guess knows them."""
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


@cache
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
CUBIC = re.compile(r"\b(cu|cubic)\.?\s+", re.IGNORECASE)
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
    if MILLIONS.fullmatch(text) or (above and unit != ABOVE_SEA):
        return None
    target = "m" if unit == ABOVE_SEA else unit
    try:
        found = _registry().Quantity(_spelt(text)).to(_spelt(target)).magnitude
    except Exception:  # whatever pint says of a text that is no unit
        return None
    return float(found) if isinstance(found, int | float) and 0.0 < found < math.inf else None


def _spelt(text: str) -> str:
    text = CUBIC.sub(r"\1_", text.replace("²", "2").replace("³", "3"))
    return POWER.sub(r"**\1", WORDS.get(text.casefold(), text))


@cache
def _registry() -> Any:
    from pint import UnitRegistry  # noqa: PLC0415 (slow to import)

    return UnitRegistry()
