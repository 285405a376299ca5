"""The languages of the report: sentences from gettext catalogues, numbers and dates by Babel.

Words are made in the language that is spoken: English, unless within `speaking`.
"""

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from datetime import date
from functools import cache
from gettext import GNUTranslations, NullTranslations
from importlib.resources import files
from io import BytesIO
from typing import Any, Literal, get_args

from avahazard.notes import Writer

LanguageName = Literal["en", "de", "fr", "it"]
LANGUAGES: tuple[str, ...] = get_args(LanguageName)
NARROW = "\u202f"
"""A narrow space that does not break, between thousands: a point is a decimal one in places."""
COMMAND = re.compile(r"\[[^]]*\]")
EFFECT = "effect"
"""Context of the names of effects in the catalogues."""


@dataclass(frozen=True, slots=True, eq=False)
class Language(Writer):
    """How a language writes sentences, notes and numbers."""

    code: str
    decimal: str
    catalogue: NullTranslations
    plain: bool = False
    """Numbers as programs read them, for a terminal."""

    def translated(self, sentence: str) -> str:
        """The sentence in this language; one that no catalogue has, such as a name, as it is."""
        return self.catalogue.gettext(sentence) if sentence else ""

    def chosen(self, one: str, many: str, n: int) -> str:
        """The sentence in this language for `n` things."""
        return self.catalogue.ngettext(one, many, n)

    def note(self, stored: object) -> str:
        """The sentence of a note, or of what the database has of one."""
        return Writer.note(self, stored).replace(" m3", " m³")

    def with_commands(self, sentence: str) -> str:
        """The sentence; in a report without commands."""
        return Writer.with_commands(self, sentence if self.plain else COMMAND.sub("", sentence))

    def effect(self, key: str) -> str:
        """The name of an effect; in English, and where it is a user's own, its key."""
        known = self.catalogue.pgettext(EFFECT, key)
        kind, mark, column = key.partition(":")
        if mark and known == key and self.code != "en":
            names = " × ".join(map(self.column, column.split("*")))
            return self.catalogue.pgettext(EFFECT, kind + ":{column}").format(column=names)
        return known

    def column(self, name: str) -> str:
        """The name of a column; in English, and if it is a user's own, as recorded."""
        from avahazard.report.words import NAMES  # noqa: PLC0415 (it imports this module)

        known = "" if self.code == "en" else NAMES["axis"].get(name, "")
        return self.translated(known) or name

    def meaning(self, key: str, words: str) -> str:
        """What an effect means, `words` of its own; of one that is made, by those of its kind."""
        from avahazard.effects.catalogue import MADE  # noqa: PLC0415 (slow)

        known = self.translated(words)
        kind, mark, of = key.partition(":")
        if known != words or (made := MADE.get(kind + mark)) is None:
            return known
        columns = dict(zip(("column", "other"), map(self.column, of.split("*")), strict=False))
        of_kind = made("*".join(f"{{{name}}}" for name in columns)).meaning
        return self.translated(of_kind).format(**columns)

    def effects(self, keys: Iterable[str]) -> str:
        """The names of effects in a row, as a sentence has them."""
        return self.listed([self.effect(key) for key in keys])

    def number(self, text: str) -> str:
        """A number as Python writes it (`-1,234.5`, `12%`) with the signs of this language."""
        text = Writer.number(self, text)
        if self.plain:
            return text.replace(",", "")
        if text.endswith("%") and text[-2:-1].isdigit() and self.code != "en":
            text = f"{text[:-1]}\u00a0%"
        return text.translate({ord(","): NARROW, ord("."): self.decimal, ord("-"): "−"})

    def date(self, text: str) -> str:
        """An ISO date as this language writes it; a year, or words, as they are."""
        if self.code == "en" or not re.fullmatch(r"\d{4}-\d\d-\d\d", text):
            return text
        from babel.dates import format_date  # noqa: PLC0415 (slow)

        return str(format_date(date.fromisoformat(text), locale=self.code))


ENGLISH = Language("en", ".", NullTranslations())
TERMINAL = Language("en", ".", NullTranslations(), plain=True)
SPOKEN: ContextVar[Language] = ContextVar("language", default=ENGLISH)


def spoken() -> Language:
    """The language that is spoken."""
    return SPOKEN.get()


@contextmanager
def speaking(language: Language) -> Iterator[None]:
    """Let a language be spoken."""
    before = SPOKEN.set(language)
    try:
        yield
    finally:
        SPOKEN.reset(before)


def say(message: str, /, **values: object) -> str:
    """A sentence in the language that is spoken, with its places filled."""
    return spoken().say(message, **values)


def plural(one: str, many: str, n: int, /, **values: object) -> str:
    """The same with a number `{n}` of things."""
    return spoken().plural(one, many, n, **values)


@cache
def language_of(code: str) -> Language:
    """The language of that code, one of `LANGUAGES`."""
    if code == "en":
        return ENGLISH
    # Read as they are written: no step that compiles them can be forgotten.
    from babel.messages.mofile import write_mo  # noqa: PLC0415 (slow)
    from babel.numbers import get_decimal_symbol  # noqa: PLC0415

    catalogue = read_catalogue(code)
    compiled = BytesIO()
    write_mo(compiled, catalogue)
    compiled.seek(0)
    return Language(code, get_decimal_symbol(code), GNUTranslations(compiled))


def read_catalogue(code: str) -> Any:
    """The catalogue of a language, as Babel reads it."""
    from babel.messages.pofile import read_po  # noqa: PLC0415 (slow)

    folder = files("avahazard.report") / "locale" / code / "LC_MESSAGES"
    with (folder / "avahazard.po").open("rb") as file:
        return read_po(file, locale=code)
