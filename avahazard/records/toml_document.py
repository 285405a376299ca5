"""TOML files held to a form, with one message for the first place at fault."""

import tomllib
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from avahazard.records.errors import AvahazardError, did_you_mean


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
        what, meant = _fault(first, form)
        message = f"{name}, {_place(first['loc'])}: {what}{given}."
        raise AvahazardError(message, f"{meant}{hint}") from error


def _fault(error: ErrorDetails, form: type[Strict]) -> tuple[str, str]:
    """What is wrong, and what may be meant by a key that is not known here."""
    *above, key = map(str, error["loc"])
    if above and key in form.model_fields:
        return f"this key stands above [{above[-1]}]", ""
    if error["type"] != "extra_forbidden":
        return error["msg"], ""
    schema = form.model_json_schema()
    tables = schema, *schema.get("$defs", {}).values()
    known = {name for table in tables for name in table.get("properties", ())}
    if key in known:
        return "this key does not stand here", ""
    return "there is no such key", did_you_mean(key, sorted(known))


def _place(location: tuple[int | str, ...]) -> str:
    """Say `zone 2, rule 1, pressure_kpa_min` for its location in the document."""
    words: list[str] = []
    for part in location:
        if isinstance(part, int):
            words[-1] += f" {part + 1}"
        else:
            words.append(part)
    return ", ".join(words)
