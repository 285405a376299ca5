"""The languages of the report: sentences from gettext catalogues, numbers and dates by Babel."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from functools import cache
from gettext import GNUTranslations, NullTranslations
from importlib.resources import files
from io import BytesIO
from typing import Any, Literal, get_args

from avahazard.records.errors import AvahazardError

LanguageName = Literal["en", "de", "fr", "it"]
LANGUAGES: tuple[str, ...] = get_args(LanguageName)
NARROW = "\u202f"
"""A narrow space that does not break: between thousands in English, as in French."""
TOLD, EFFECT = "told", "effect"
"""Contexts of the catalogues: sentences that results bring, and names of effects."""
NUMBER = re.compile(
    r"([<>+−-]? ?(?:\d{1,3}(?: \d{3})+|\d[\d,]*)(?:\.\d+)?(?:e[+-]\d+)?)( ?(?:%|m|m3|m/s|°))?"
)
CUBIC = re.compile(r"(?<=\d m)3\b")
"""The 3 of cubic metres, as results write them."""
LARGE = 1e4
"""From here on a number that stands without signs between its thousands gets them."""
LISTS, EFFECTS = ("paths", "events", "parts"), ("one", "other")
"""Places of told sentences that hold names in a row, or the key of an effect."""
PLACE = re.compile(r"\\\{(\w+)\\\}")


@dataclass(frozen=True, slots=True, eq=False)
class Language:
    """What a report says and how it writes numbers; `told_as` are patterns of told sentences."""

    code: str
    decimal: str
    group: str
    catalogue: NullTranslations
    told_as: tuple[tuple[re.Pattern[str], str], ...] = ()

    def say(self, message: str, /, **values: object) -> str:
        """A sentence of the report in this language, with its named places filled."""
        text = self.catalogue.gettext(message)
        return text.format(**values) if values else text

    def plural(self, one: str, many: str, n: int, /, **values: object) -> str:
        """The same with a number `{n}` of things."""
        return self.catalogue.ngettext(one, many, n).format(n=n, **values)

    def effect(self, key: str) -> str:
        """The name of an effect; in English, and where it is a user's own, its key."""
        kind, mark, column = key.partition(":")
        if mark:
            return self.catalogue.pgettext(EFFECT, kind + ":{column}").format(column=column)
        return self.catalogue.pgettext(EFFECT, key)

    def told(self, text: str) -> str:
        """A sentence that a result brought in English, in this language.

        What stands in its places is translated too; lists are, item by item. A text that no
        catalogue knows, such as a name, is left as it is.
        """
        if self.code == "en":
            return CUBIC.sub("³", text)
        known = self._sentence(text)
        if known is not None:
            return known
        number = NUMBER.fullmatch(text)
        if number:
            return self._measured(number[1], number[2] or "")
        whose, mark, rest = text.partition(": ")
        if mark and self.told(rest) != rest:
            return f"{whose}: {self.told(rest)}"
        for mark in () if text.endswith(".") else ("; ", ", "):
            if mark in text:
                return mark.join(self._items(text.split(mark), mark))
        return text

    def _sentence(self, text: str) -> str | None:
        """A sentence that a catalogue knows, by its words or by its pattern."""
        known = self.catalogue.pgettext(TOLD, text)
        if known != text:
            return known
        for pattern, message in self.told_as:
            found = pattern.fullmatch(text)
            if found:
                values = {
                    name: self._place(name, value) for name, value in found.groupdict().items()
                }
                return self.catalogue.pgettext(TOLD, message).format(**values)
        return None

    def _place(self, name: str, text: str) -> str:
        """What stands in a place of a told sentence, by the place's name."""
        if name in EFFECTS:
            return self.effect(text)
        return self._listed(text) if name in LISTS else self.told(text)

    def _items(self, parts: list[str], mark: str) -> Iterator[str]:
        """The items of a list; one that holds its mark itself is two parts."""
        k = 0
        while k < len(parts):
            both = self._sentence(mark.join(parts[k : k + 2]))
            yield self.told(parts[k]) if both is None else both
            k += 1 if both is None else 2

    def _listed(self, text: str) -> str:
        """Names in a row, the last after an “and”."""
        some, mark, last = text.rpartition(" and ")
        if not mark:
            return self.told(text)
        return self.say("{some} and {last}", some=self.told(some), last=self.told(last))

    def _measured(self, number: str, unit: str) -> str:
        """A number that a result brought, with its unit."""
        number = re.sub(r"(?<=\d) (?=\d)", "", number)
        if number[0].isdigit() and "," not in number and float(number) >= LARGE:
            number = f"{float(number):,.0f}"
        space = " " if unit.strip() == "%" else ""
        return self.number(number) + (space + unit.strip() if space else unit).replace("m3", "m³")

    def number(self, text: str) -> str:
        """A number as Python writes it (`-1,234.5`) with the signs of this language."""
        return text.translate({ord(","): self.group, ord("."): self.decimal, ord("-"): "−"})

    def date(self, text: str) -> str:
        """An ISO date as this language writes it; a year, or words, as they are."""
        if self.code == "en" or not re.fullmatch(r"\d{4}-\d\d-\d\d", text):
            return text
        from babel.dates import format_date  # noqa: PLC0415 (slow)

        return str(format_date(date.fromisoformat(text), locale=self.code))

    @property
    def separators(self) -> str:
        """Decimal sign and sign between thousands, as Plotly wants them."""
        return self.decimal + self.group


ENGLISH = Language("en", ".", NARROW, NullTranslations())


@cache
def language_of(code: str) -> Language:
    """The language of that code.

    Raises:
        AvahazardError: there is none.
    """
    if code == "en":
        return ENGLISH
    if code not in LANGUAGES:
        raise AvahazardError(
            f"There is no report in the language '{code}'.", f"There are {', '.join(LANGUAGES)}."
        )
    # Read as they are written: no step that compiles them can be forgotten.
    from babel.messages.mofile import write_mo  # noqa: PLC0415 (slow)
    from babel.numbers import get_decimal_symbol, get_group_symbol  # noqa: PLC0415

    catalogue = read_catalogue(code)
    compiled = BytesIO()
    write_mo(compiled, catalogue)
    compiled.seek(0)
    told = [str(m.id) for m in catalogue if m.id and m.context == TOLD and "{" in str(m.id)]
    return Language(
        code,
        get_decimal_symbol(code),
        get_group_symbol(code),
        GNUTranslations(compiled),
        # The one that says most comes first.
        tuple((_pattern(m), m) for m in sorted(told, key=_said, reverse=True)),
    )


def read_catalogue(code: str) -> Any:
    """The catalogue of a language, as Babel reads it."""
    from babel.messages.pofile import read_po  # noqa: PLC0415 (slow)

    folder = files("avahazard.report") / "locale" / code / "LC_MESSAGES"
    with (folder / "avahazard.po").open("rb") as file:
        return read_po(file, locale=code)


def _pattern(message: str) -> re.Pattern[str]:
    """What a sentence looks like; a place that comes again holds the same."""
    seen: set[str] = set()

    def place(found: re.Match[str]) -> str:
        name = found[1]
        if name in seen:
            return f"(?P={name})"
        seen.add(name)
        return f"(?P<{name}>.+?)"

    return re.compile(PLACE.sub(place, re.escape(message)), re.DOTALL)


def _said(message: str) -> int:
    """Letters outside the places."""
    return len(re.sub(r"\{\w+\}", "", message))
