"""Notes: sentences for people, as a key and its values; in English they stand in `notes.toml`.

Who finds something worth a note says `Note("stale", model="base")`. A note is its English sentence
too, so that whatever takes text takes it; the report says it in another language by its key
(`report.language`), and the database keeps key and values.
"""

from __future__ import annotations

import re
import shlex
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from string import Formatter
from typing import Any, Self

FEW = 3
"""Names that a line for people holds before `and n more`."""
NEGATIVE_ZERO = re.compile(r"^[-−](?=0[.0]*( ?%)?$)")

_known: dict[str, dict[str, str | list[str]]] = tomllib.loads(
    (files("avahazard") / "notes.toml").read_text("utf-8")
)
SENTENCES, TERMINAL = _known["report"], _known["terminal"]
"""Sentences by key, and those that no report shows and no language has."""


@dataclass(frozen=True, slots=True)
class Range:
    """From the least to the largest of the numbers of several notes."""

    low: float
    high: float


class Writer(Formatter):
    """Fills the places of sentences; as it is, in English."""

    def translated(self, sentence: str) -> str:
        """The sentence in the language."""
        return sentence

    def chosen(self, one: str, many: str, n: int) -> str:
        """The sentence in the language for `n` things."""
        return one if n == 1 else many

    def number(self, text: str) -> str:
        """A number as Python writes it (`-1,234.5`, `12%`) in the language; zero has no sign."""
        return NEGATIVE_ZERO.sub("", text)

    def with_commands(self, sentence: str) -> str:
        """A sentence with what the command line can do about it, which stands in brackets."""
        return sentence.replace("[", "").replace("]", "")

    def column(self, name: str) -> str:
        """The name of a column of the records."""
        return name

    def say(self, message: str, /, **values: object) -> str:
        """A sentence in the language, with its places filled."""
        text = self.translated(message)
        return self.vformat(text, (), values) if values else text

    def plural(self, one: str, many: str, n: int, /, **values: object) -> str:
        """The same with a number `{n}` of things."""
        return self.vformat(self.chosen(one, many, n), (), {"n": n, **values})

    def note(self, stored: object) -> str:
        """The sentence of a note, or of what the database has of one."""
        note = Note.read(stored)
        if not note.key:
            return self.translated(str(note))
        return self.sentence(note.key, note.of, note.values)

    def alone(self, stored: object) -> str:
        """The sentence of a note that stands alone: with a capital, but for a name at its begin."""
        note, text = Note.read(stored), self.note(stored)
        known = SENTENCES.get(note.key) or TERMINAL.get(note.key, "{")
        first = self.translated(known if isinstance(known, str) else known[0])
        return text if note.of or first.startswith("{") else f"{text[:1].upper()}{text[1:]}"

    def sentence(self, key: str, of: Sequence[str], values: Mapping[str, Any]) -> str:
        """The sentence of that key, after what it is of."""
        sentence = SENTENCES.get(key) or TERMINAL.get(key)
        if sentence is None:  # of another version of the program
            text = ", ".join((key, *(f"{name} {value}" for name, value in values.items())))
        elif isinstance(sentence, str):
            text = self.vformat(self.with_commands(self.translated(sentence)), (), values)
        else:
            one, many = sentence
            text = self.vformat(self.chosen(one, many, values["n"]), (), values)
        return self.say("{of}: {text}", of=self.few(of), text=text) if of else text

    def few(self, names: Sequence[str], most: int = FEW) -> str:
        """The first few names in a row, and how many more; one or two more by name."""
        if len(names) <= most + 2:
            return ", ".join(names)
        first, rest = ", ".join(names[:most]), len(names) - most
        return self.say("{names} and {n} more", names=first, n=rest)

    def listed(self, names: Sequence[str]) -> str:
        """Names in a row, as a sentence has them."""
        if len(names) < 2:
            return "".join(names)
        return self.say("{some} and {last}", some=", ".join(names[:-1]), last=names[-1])

    def format_field(self, value: Any, format_spec: str) -> str:
        """What stands in a place: text, a note, a number in the language, or a row of these."""
        value = "–" if value is None else value  # a number that is not known
        if isinstance(value, Note):
            return self.note(value)
        if isinstance(value, str):
            how = {"column": self.column, "command": shlex.quote}
            return how.get(format_spec, str)(value)
        if isinstance(value, Range):
            low, high = (self.number(format(v, format_spec)) for v in (value.low, value.high))
            return low if low == high else self.say("{low} to {high}", low=low, high=high)
        if isinstance(value, list | tuple):
            names = [self.format_field(item, "") for item in value]
            if format_spec in ("and", "few"):
                return self.listed(names) if format_spec == "and" else self.few(names)
            return (format_spec or ", ").join(names)
        return self.number(format(value, format_spec))


ENGLISH = Writer()


class Note(str):
    """An English sentence that knows its `key` of `SENTENCES`, its `values`, and what it is `of`.

    `of` are the names of paths or events that it is about, if any. A sentence without a key is
    one that was ready, as those in databases of earlier versions.
    """

    key: str
    of: tuple[str, ...]
    values: dict[str, Any]

    def __new__(cls, key: str, of: str | Sequence[str] = (), /, **values: Any) -> Self:
        """The note of that key, with the values of its places."""
        names = (of,) if isinstance(of, str) else tuple(of)
        return cls._made(ENGLISH.sentence(key, names, values), key, names, values)

    @classmethod
    def ready(cls, text: str) -> Self:
        """A sentence without a key, which no language translates."""
        return cls._made(text, "", (), {})

    @classmethod
    def _made(cls, text: str, key: str, of: tuple[str, ...], values: dict[str, Any]) -> Self:
        note = super().__new__(cls, text)
        note.key, note.of, note.values = key, of, values
        return note

    @classmethod
    def read(cls, stored: Any) -> Note:
        """The note that a database holds: key and values, or in old ones the sentence."""
        if isinstance(stored, Note):
            return stored
        if isinstance(stored, str):
            return cls.ready(stored)
        values = {name: _read(value) for name, value in stored.get("values", {}).items()}
        return cls(stored["key"], stored.get("of", ()), **values)

    def stored(self) -> Any:
        """What the database keeps of it: `read` gives it back."""
        if not self.key:
            return str(self)
        values = {name: _stored(value) for name, value in self.values.items()}
        found = {"key": self.key, "of": list(self.of), "values": values}
        return {name: value for name, value in found.items() if value}

    def about(self, *names: str) -> Note:
        """The same about these paths or events."""
        if self.key:
            return Note(self.key, names, **self.values)
        return Note.ready(f"{ENGLISH.few(names)}: {self}")

    def __reduce__(self) -> tuple[Any, ...]:
        return Note.read, (self.stored(),)

    @classmethod
    def __get_pydantic_core_schema__(cls, _source: Any, _handler: Any) -> Any:
        from pydantic_core import core_schema  # noqa: PLC0415 (slow to import)

        return core_schema.no_info_plain_validator_function(cls.read)


def _read(value: Any) -> Any:
    if isinstance(value, Mapping):
        return Note.read(value)
    return [_read(item) for item in value] if isinstance(value, list) else value


def _stored(value: Any) -> Any:
    if isinstance(value, Note):
        return value.stored()
    return [_stored(item) for item in value] if isinstance(value, list | tuple) else value


def placed(where: Mapping[Note, Iterable[str]], n_paths: int) -> list[Note]:
    """Each note with the paths that it is on; one that is on all of several is on none."""
    found = {note: tuple(paths) for note, paths in where.items()}
    return [n if len(p) == n_paths > 1 else n.about(*p) for n, p in found.items()]


def grouped(notes: Iterable[str]) -> list[Note]:
    """For people: notes that differ in numbers and in what they are of as one, with ranges."""
    found: dict[Any, Note] = {}
    for note in map(Note.read, notes):
        kind = _kind(note)
        found[kind] = _joined(found[kind], note) if kind in found else note
    return list(found.values())


def _kind(value: Any) -> Any:
    """What must be equal for two notes to be one: all but numbers and rows of names."""
    if isinstance(value, Note) and value.key:
        places = sorted((name, _kind(item)) for name, item in value.values.items())
        return (value.key, bool(value.of), *places)
    return str(value) if value is None or isinstance(value, str) else ""


def _joined(one: Any, other: Any) -> Any:
    """Two values of one kind as one: the names of both, the least and the largest number."""
    if isinstance(one, Note) and one.key:
        values = {
            name: value + other.values[name] if name == "n" else _joined(value, other.values[name])
            for name, value in one.values.items()
        }
        of = dict.fromkeys((*one.of, *other.of))
        # The same note of the same path twice is no second thing.
        return one if one == other else Note(one.key, tuple(of), **values)
    if isinstance(one, str) or one == other:
        return one
    if isinstance(one, list | tuple):
        return list(dict.fromkeys((*one, *other)))
    low, high = ((v.low, v.high) if isinstance(v, Range) else (v, v) for v in (one, other))
    return Range(min(low[0], high[0]), max(low[1], high[1]))


def counted(n: int, thing: str) -> str:
    """A number of things in English: `1 event`, `3 events`."""
    return f"{n} {thing if n == 1 else thing + 's'}"
