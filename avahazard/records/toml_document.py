"""TOML files held to a form, with one message for the first place at fault."""

import tomllib
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from avahazard.records.errors import AvahazardError


class Strict(BaseModel):
    """A table of a TOML file: no unknown keys, no value of another type."""

    model_config = ConfigDict(extra="forbid", strict=True)


Form = TypeVar("Form", bound=Strict)


def read_toml(name: str, text: str, form: type[Form], hint: str) -> Form:
    """Read `text`, a TOML document of that form; `name` is that of its file.

    Raises `AvahazardError` where it is no TOML, or a value is missing, unknown or out of its range.
    The message names the first place at fault; `hint` says what would be right.
    """
    try:
        return form.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise AvahazardError(f"{name} is not a TOML file: {error}.", hint) from error
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        given = "" if first["type"] == "missing" else f" (given: {first['input']!r})"
        message = f"{name}, {_place(first['loc'])}: {first['msg']}{given}."
        raise AvahazardError(message, hint) from error


def _place(location: tuple[int | str, ...]) -> str:
    """Say `zone 2, rule 1, pressure_kpa_min` for its location in the document."""
    words: list[str] = []
    for part in location:
        if isinstance(part, int):
            words[-1] += f" {part + 1}"
        else:
            words.append(part)
    return ", ".join(words)
