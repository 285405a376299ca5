"""The catalogue: every effect by its key (docs/effects.md is made from it)."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

import avahazard.effects as folder
from avahazard.effects import change, covariate, groups, pairs
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition
from avahazard.effects.site import Site
from avahazard.records.errors import AvahazardError, did_you_mean

MADE: Mapping[str, Callable[[str], Definition]] = {
    covariate.PREFIX: covariate.covariate,
    pairs.INTERACTION: pairs.interaction,
    change.CHANGE: change.change,
    covariate.SCATTER: covariate.scatter_by,
    groups.PATH: groups.one_path,
}
"""Effects that are made for what a file has, by the beginning of their key."""


@cache
def catalogue() -> Mapping[str, Definition]:
    """Every effect by key: each `Definition` that a file of this folder holds."""
    modules = [import_module(f"{folder.__name__}.{m.name}") for m in iter_modules(folder.__path__)]
    held = [entry for m in modules for entry in vars(m).values() if isinstance(entry, Definition)]
    return {entry.key: entry for entry in sorted(held, key=lambda e: (e.order, e.key))}


def definition(key: str) -> Definition:
    """The entry of a key, made for kinds such as `covariate:COLUMN`; unknown ones are refused."""
    for prefix, made in MADE.items():
        if key.startswith(prefix) and len(key) > len(prefix):
            return made(key.removeprefix(prefix))
    known = catalogue()
    if key not in known:
        raise AvahazardError(
            f"There is no effect '{key}'.",
            f"{did_you_mean(key, known)}Effects: "
            f"{', '.join((*known, *(f'{prefix}…' for prefix in MADE)))}.",
        )
    return known[key]


def require(entry: Definition, columns: EventColumns, sites: Sequence[Site]) -> None:
    """Raise `AvahazardError` where the data lack what the effect needs."""
    lack = entry.lacking(columns, sites)
    if lack is not None:
        raise AvahazardError(
            f"The effect '{entry.key}' cannot be estimated from these data: {lack}.",
            f"It needs: {entry.needs}.",
        )
