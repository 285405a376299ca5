"""Limits of hazard zones: which pressure, at which return period, puts a place in which zone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from avahazard.records.errors import AvahazardError
from avahazard.records.toml_document import Strict, read_toml


@dataclass(frozen=True, slots=True)
class Rule:
    """Holds where `pressure_kpa_min` is exceeded once in `return_period_years` on average.

    With a least pressure of 0 it holds wherever an avalanche of that return period comes at all.
    """

    return_period_years: float
    pressure_kpa_min: float = 0.0


@dataclass(frozen=True, slots=True)
class ZoneLimits:
    """A zone: a place is in it where one of its `rules` holds and no worse zone's does."""

    name: str
    color: str
    rules: tuple[Rule, ...]


@dataclass(frozen=True, slots=True)
class ZoneSystem:
    """Zones, the worst first; `notes` say what of the regulation the model cannot answer."""

    name: str
    zones: tuple[ZoneLimits, ...]
    notes: tuple[str, ...] = ()

    @property
    def return_periods(self) -> tuple[float, ...]:
        """The return periods (years) that the rules speak of, rising."""
        return tuple(sorted({r.return_period_years for z in self.zones for r in z.rules}))


RED, BLUE, YELLOW = "#c8102e", "#0072b2", "#f0e442"

SWISS = ZoneSystem(
    "swiss",
    # Guideline of 1984 (BFF and SLF), as the canton of Valais states it: red is 30 kN/m2 or more
    # at up to 300 years, or any pressure at up to 30 years; blue is less than 30 kN/m2 at 30 to
    # 300 years.
    (
        ZoneLimits("red", RED, (Rule(300.0, 30.0), Rule(30.0))),
        ZoneLimits("blue", BLUE, (Rule(300.0),)),
    ),
    (
        "swiss: yellow (powder under 3 kPa, flowing avalanches rarer than 300 years) and the "
        "powder part of blue are outside this model.",
    ),
)
"""Swiss practice: red prohibits building, blue allows it with conditions."""

FRENCH = ZoneSystem(
    "french",
    # Guide PPRN Avalanches (2015): the hundred-year reference avalanche (ARC) gives red where it
    # is strong, 30 kPa or more, and blue below; the exceptional one (ARE, about 300 years), yellow.
    (
        ZoneLimits("red", RED, (Rule(100.0, 30.0),)),
        ZoneLimits("blue", BLUE, (Rule(100.0),)),
        ZoneLimits("yellow", YELLOW, (Rule(300.0),)),
    ),
    (
        "french: the limits are those of pressure alone; powder, land use and the judgement of "
        "the service that makes the plan are outside this model.",
    ),
)
"""French practice (plans de prévention des risques): red, blue, and yellow for the exceptional."""

PRESETS = {limits.name: limits for limits in (SWISS, FRENCH)}


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


def read_limits(name: str, text: str) -> ZoneSystem:
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
    return ZoneSystem(
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
