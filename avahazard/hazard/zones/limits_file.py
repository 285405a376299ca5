"""Limits of one's own, from a small TOML file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from avahazard.hazard.zones.limits import Limits, Rule, ZoneLimits
from avahazard.records.errors import AvahazardError
from avahazard.records.toml_document import Strict, read_toml

EXAMPLE = (
    'A zone is written: [[zone]], name = "red", color = "#c8102e", and for each rule '
    "[[zone.rule]], return_period_years = 300, pressure_kpa_min = 30."
)
Name = Annotated[str, Field(min_length=1)]


class _Rule(Strict):
    return_period_years: Annotated[float, Field(gt=1.0, allow_inf_nan=False)]
    pressure_kpa_min: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] = 0.0


class _Zone(Strict):
    name: Name
    color: Annotated[str, Field(pattern="^#[0-9a-fA-F]{6}$")]
    rule: Annotated[list[_Rule], Field(min_length=1)]


class _Limits(Strict):
    zone: Annotated[list[_Zone], Field(min_length=1)]


def read_limits(name: str, text: str) -> Limits:
    """Read the limits in `text`, a TOML document; `name` is that of its file.

    Zones stand in it from the worst to the least.

    Raises:
        AvahazardError: it is no TOML, a value is missing, unknown or out of its range, or two
            zones have one name. The message names the first place at fault.
    """
    found = read_toml(name, text, _Limits, EXAMPLE)
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
