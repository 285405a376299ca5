"""What a use case is asked: a frozen class whose fields say all there is to say of an option.

The command line, the Python API and the file of a project take their options from these classes.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import KW_ONLY, MISSING, dataclass, field, fields
from numbers import Real
from pathlib import Path
from types import NoneType
from typing import (
    Any,
    Literal,
    TypeVar,
    cast,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

from avahazard.records.errors import AvahazardError, did_you_mean

Item = TypeVar("Item")


@dataclass(frozen=True, slots=True)
class Option:
    """What a field is, in one line of help, and which values it may have.

    `flag` and `short` are its names on the command line, where they are not made of the field's.
    Numbers lie `over` a value, or from `least` to `most`; `what` and `unit` name them in messages.
    The help shows `metavar` for the value, by default its unit, FILE for a path.
    `choices` are the texts that it may be, asked for when they are needed; `parse` reads the
    values of a command line.
    """

    help: str
    _: KW_ONLY
    flag: str | None = None
    short: str | None = None
    metavar: str | None = None
    what: str | None = None
    unit: str = ""
    over: float | None = None
    least: int | float | None = None
    most: int | float | None = None
    choices: Callable[[], Iterable[str]] | None = None
    parse: Callable[[Sequence[str]], Any] | None = None

    def within(self, value: float) -> tuple[bool, str]:
        """Whether a number is within the bounds, and these in words."""
        least = -math.inf if self.least is None else self.least
        most = math.inf if self.most is None else self.most
        upto = "" if self.most is None else f" to {most:.15g}"
        if self.over is not None:
            return self.over < value <= most, f"over {self.over:g}{upto and ', up'}{upto}"
        return least <= value <= most, f"from {least:.15g}{upto}"


def option(default: Item, told: Option | str, **more: Any) -> Item:
    """The default of a field that is an option: `told`, or its help and what `more` is to say."""
    metadata = {"option": told if isinstance(told, Option) else Option(told, **more)}
    made: Any = field(default=default, metadata=metadata)
    if default == {}:
        made = field(default_factory=dict, metadata=metadata)
    return cast(Item, made)


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a request: its name, the type of one value, whether it may have several."""

    name: str
    kind: Any
    many: bool
    default: Any
    option: Option

    @property
    def flag(self) -> str:
        """Its name on the command line: in the singular where it may be given again."""
        if self.option.flag is not None:
            return self.option.flag
        name = self.name.rstrip("_").replace("_", "-")
        return f"--{name.removesuffix('s') if self.many else name}"

    @property
    def metavar(self) -> str | None:
        """What stands for a value in the help, if anything."""
        unit = self.option.unit.upper().replace("/", "_")
        return self.option.metavar or unit or ("FILE" if self.kind is Path else None)

    @property
    def choices(self) -> tuple[str, ...]:
        """The texts that it may be; empty where it may be any."""
        if get_origin(self.kind) is Literal:
            return get_args(self.kind)
        return () if self.option.choices is None else tuple(self.option.choices())

    def read(self, value: Any) -> Any:
        """The value in its own type. Raises `AvahazardError` where it may not have this one."""
        option = self.option
        name = self.name.removesuffix("s") if self.many else self.name
        what = option.what or name.rstrip("_").replace("_", " ")
        if value is not None and (known := self.choices) and value not in known:
            raise AvahazardError(
                f"There is no {what} '{value}'.",
                f"{did_you_mean(str(value), known)}It is one of: {', '.join(known)} ({self.flag}).",
            )
        if self.kind in (int, float) and value is not None:
            if not isinstance(value, Real) or isinstance(value, bool) or value != self.kind(value):
                raise AvahazardError(
                    f"The {what} is {value!r}.",
                    f"It must be a {'whole ' * (self.kind is int)}number {option.within(0.0)[1]}.",
                )
            value = self.kind(value)
        if isinstance(value, int | float) and not isinstance(value, bool):
            good, bounds = option.within(value)
            if not (good and math.isfinite(value)):
                of = f" of {option.unit}" if option.unit else ""
                raise AvahazardError(
                    f"The {what} is {value:g}.", f"It must be a number{of} {bounds}."
                )
        return Path(value) if self.kind is Path and isinstance(value, str) else value


@dataclass_transform(frozen_default=True, kw_only_default=True)
@dataclass(frozen=True, kw_only=True)
class Request:
    """What a use case is asked; one value may stand for a sequence of one.

    Its classes are frozen dataclasses without a decorator. Raises `AvahazardError` where a value is
    out of range, or none of those that may be chosen.
    """

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, kw_only=True)(cls)

    def __post_init__(self) -> None:
        for of in fields_of(type(self)):
            value = getattr(self, of.name)
            values = tuple(of.read(one) for one in (many(value) if of.many else (value,)))
            value = tuple(dict.fromkeys(values)) if of.many else values[0]
            object.__setattr__(self, of.name, value)
        self.check()

    def check(self) -> None:
        """Raise `AvahazardError` for values that do not go together."""


def fields_of(request: type[Request]) -> tuple[Field, ...]:
    """The options of a request, in their order, less those of a request within it."""
    return tuple(part for part in parts_of(request) if isinstance(part, Field))


def parts_of(request: type[Request]) -> Iterator[Field | tuple[str, type[Request]]]:
    """The options of a request, and the requests within it by the name of their field."""
    hints = get_type_hints(request)
    for found in fields(request):
        hint = hints[found.name]
        if isinstance(hint, type) and issubclass(hint, Request):
            yield found.name, hint
        elif "option" in found.metadata:
            several = get_origin(hint) is Sequence
            kinds = [kind for kind in get_args(hint) if kind is not NoneType]
            optional = not several and NoneType in get_args(hint)
            kind = kinds[0] if several or optional else hint
            default = None if found.default is MISSING else found.default
            yield Field(found.name, kind, several, default, found.metadata["option"])


def many(value: Iterable[Item] | Item) -> tuple[Item, ...]:
    """The values of something that may be one of them: text and paths are one."""
    if isinstance(value, str | Path) or not isinstance(value, Iterable):
        return (value,)
    return tuple(value)
