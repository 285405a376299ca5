"""The catalogue: every effect by its key (docs/effects.md is made from it)."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module

from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import PREFIX, covariate
from avahazard.effects.effect import Definition
from avahazard.effects.site import Site
from avahazard.records.errors import AvahazardError

KEYS = (
    "centrifugal",
    "turbulent-drag",
    "speed-weakening",
    "cohesion",
    "entrainment",
    "forest-drag",
    "volume-law",
    "volume-scatter",
    "snow-type",
    "path-section",
    "release-elevation",
    "season",
    "path-effect",
    "observation-limit",
    "epoch-bias",
    "leading-edge",
)


def definition(key: str) -> Definition:
    """The entry of that key; `covariate:COLUMN` makes one for any column.

    Raises `AvahazardError` for an unknown key.
    """
    if key.startswith(PREFIX) and len(key) > len(PREFIX):
        return covariate(key[len(PREFIX) :])
    if key not in KEYS:
        raise AvahazardError(
            f"There is no effect '{key}'.", f"Effects: {', '.join(KEYS)}, {PREFIX}COLUMN."
        )
    module = import_module(f"avahazard.effects.{key.replace('-', '_')}")
    entry: Definition = module.DEFINITION
    return entry


def require(entry: Definition, columns: EventColumns, sites: Sequence[Site]) -> None:
    """Raise `AvahazardError` where the data lack what the effect needs."""
    lack = entry.lacking(columns, sites)
    if lack is not None:
        raise AvahazardError(
            f"The effect '{entry.key}' cannot be told from these data: {lack}.",
            f"It needs: {entry.needs}.",
        )
