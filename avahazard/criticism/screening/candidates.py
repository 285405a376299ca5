"""Which effects could be missing: all that the data can tell and the model does not have."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.effects.catalogue import catalogue
from avahazard.effects.covariate import covariate
from avahazard.effects.effect import Definition
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification

COMMON_COLUMNS = ("year", "deposit_length_m")
"""Columns that are not covariates of a file but may drive friction."""


def candidate_definitions(
    observations: Observations, specification: Specification, own: Sequence[Definition] = ()
) -> list[Definition]:
    """Effects of the catalogue, of the user's file, and a smooth of every column."""
    known = catalogue().values()
    columns = [*observations.columns.numbers, *observations.columns.texts, *COMMON_COLUMNS]
    # A smooth of a column that has an effect of its own would only repeat it.
    smooths = [covariate(c) for c in dict.fromkeys(columns) if c not in {e.column for e in known}]
    data = observations.columns, observations.sites
    return [
        entry
        for entry in (*own, *known, *smooths)
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
