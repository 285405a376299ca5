"""Which effects could be missing."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from avahazard.effects.catalogue import catalogue
from avahazard.effects.change import ALL, change
from avahazard.effects.covariate import VOLUME, covariate, interaction, scatter_by
from avahazard.effects.effect import Definition
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification

COMMON_COLUMNS = ("year", "deposit_length_m")
"""Columns that are not covariates of a file but may drive friction."""


def candidate_definitions(
    observations: Observations, specification: Specification, own: Sequence[Definition] = ()
) -> list[Definition]:
    """Effects of the catalogue, of the user's file, and what is made of the file's columns."""
    known, columns = catalogue().values(), observations.columns
    of_events = [*columns.numbers, *columns.texts, *columns.made]
    # A smooth of a column that has an effect of its own would only repeat it.
    taken = {entry.column for entry in known}
    smooths = [covariate(c) for c in dict.fromkeys([*of_events, *COMMON_COLUMNS]) if c not in taken]
    pairs = [f"{one}*{other}" for one, other in combinations([*of_events, VOLUME], 2)]
    made = [
        *map(interaction, pairs),
        *map(scatter_by, of_events),
        *map(change, [*columns.paths, ALL]),
    ]
    data = columns, observations.sites
    return [
        entry
        for entry in (*own, *known, *smooths, *made)
        if entry.nuisance is None
        and not specification.has(entry)
        and not entry.settled(*data)
        and entry.lacking(*data) is None
    ]


def not_asked(
    observations: Observations, specification: Specification, own: Sequence[Definition] = ()
) -> dict[str, str]:
    """Effects whose column the records have, though not enough of it, and what it lacks."""
    data = observations.columns, observations.sites
    columns = {*observations.columns.numbers, *observations.columns.texts}
    lacks = {
        entry.key: entry.lacking(*data)
        for entry in (*own, *catalogue().values())
        if entry.column in columns and not specification.has(entry)
    }
    return {key: lack for key, lack in lacks.items() if lack is not None}
