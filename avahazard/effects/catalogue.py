"""The catalogue: every effect by its key (docs/effects.md is made from it)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

import avahazard.effects as folder
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import PREFIX, covariate
from avahazard.effects.effect import Definition
from avahazard.effects.site import Site
from avahazard.records.errors import AvahazardError


@cache
def catalogue() -> Mapping[str, Definition]:
    """Every effect by key: each `Definition` that a file of this folder holds."""
    modules = [import_module(f"{folder.__name__}.{m.name}") for m in iter_modules(folder.__path__)]
    held = [entry for m in modules for entry in vars(m).values() if isinstance(entry, Definition)]
    return {entry.key: entry for entry in sorted(held, key=lambda e: (e.order, e.key))}


def definition(key: str) -> Definition:
    """The entry of that key; `covariate:COLUMN` makes one for any column.

    Raises `AvahazardError` for an unknown key.
    """
    if key.startswith(PREFIX) and len(key) > len(PREFIX):
        return covariate(key[len(PREFIX) :])
    known = catalogue()
    if key not in known:
        raise AvahazardError(
            f"There is no effect '{key}'.", f"Effects: {', '.join(known)}, {PREFIX}COLUMN."
        )
    return known[key]


def require(entry: Definition, columns: EventColumns, sites: Sequence[Site]) -> None:
    """Raise `AvahazardError` where the data lack what the effect needs."""
    lack = entry.lacking(columns, sites)
    if lack is not None:
        raise AvahazardError(
            f"The effect '{entry.key}' cannot be told from these data: {lack}.",
            f"It needs: {entry.needs}.",
        )
