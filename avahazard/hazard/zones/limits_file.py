"""Limits of one's own, from a small TOML file."""

from __future__ import annotations

import tomllib
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from avahazard.hazard.zones.limits import Limits, Rule, ZoneLimits
from avahazard.records.errors import AvahazardError

EXAMPLE = (
    'A zone is written: [[zone]], name = "red", color = "#c8102e", and for each rule '
    "[[zone.rule]], return_period_years = 300, pressure_kpa_min = 30."
)
Name = Annotated[str, Field(min_length=1)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _Rule(_Strict):
    return_period_years: Annotated[float, Field(gt=1.0, allow_inf_nan=False)]
    pressure_kpa_min: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] = 0.0


class _Zone(_Strict):
    name: Name
    color: Annotated[str, Field(pattern="^#[0-9a-fA-F]{6}$")]
    rule: Annotated[list[_Rule], Field(min_length=1)]


class _Limits(_Strict):
    zone: Annotated[list[_Zone], Field(min_length=1)]


def read_limits(name: str, text: str) -> Limits:
    """Read the limits in `text`, a TOML document; `name` is that of its file.

    Zones stand in it from the worst to the least.

    Raises:
        AvahazardError: it is no TOML, a value is missing, unknown or out of its range, or two
            zones have one name. The message names the first place at fault.
    """
    try:
        found = _Limits.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise AvahazardError(f"{name} is not a TOML file: {error}.", EXAMPLE) from error
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        given = "" if first["type"] == "missing" else f" (given: {first['input']!r})"
        message = f"{name}, {_place(first['loc'])}: {first['msg']}{given}."
        raise AvahazardError(message, EXAMPLE) from error
    names = [zone.name for zone in found.zone]
    for twice in names:
        if names.count(twice) > 1:
            raise AvahazardError(f"{name} has two zones '{twice}'.", "Give each its own name.")
    return Limits(
        name,
        tuple(
            ZoneLimits(
                zone.name,
                zone.color.lower(),
                tuple(Rule(r.return_period_years, r.pressure_kpa_min) for r in zone.rule),
            )
            for zone in found.zone
        ),
    )


def _place(location: tuple[int | str, ...]) -> str:
    """Say `zone 2, rule 1, pressure_kpa_min` for its location in the document."""
    words: list[str] = []
    for part in location:
        if isinstance(part, int):
            words[-1] += f" {part + 1}"
        else:
            words.append(part)
    return ", ".join(words)
