"""Which effects could be missing: all that the data can tell and the model does not have."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.effects.catalogue import KEYS
from avahazard.effects.covariate import PREFIX
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification

OWN_COLUMNS = {"snow_type": "snow-type"}
"""Columns with an effect of their own, which a smooth of the column would only repeat."""
COMMON_COLUMNS = ("year", "deposit_length_m")
"""Columns that are not covariates of a file but may drive friction."""


def candidate_definitions(
    observations: Observations, specification: Specification, own: Sequence[Definition] = ()
) -> list[Definition]:
    """Effects of the catalogue, of the user's file, and a smooth of every column."""
    keys = [d.key for d in own] + [k for k in KEYS if k != "path-effect"]
    if specification.centrifugal:
        keys.remove("centrifugal")
    if specification.scatter == "volume":
        keys.remove("volume-scatter")
    if not np.any(np.isnan(observations.limit[observations.columns.path_index >= 0])):
        # Every path has its limit, and the likelihood knows it.
        keys.remove("observation-limit")
    columns = [*observations.columns.numbers, *observations.columns.texts, *COMMON_COLUMNS]
    keys += [PREFIX + c for c in dict.fromkeys(columns) if c not in OWN_COLUMNS]
    entries = [find_definition(k, own) for k in keys if k not in specification.effects]
    return [e for e in entries if e.lacking(observations.columns, observations.sites) is None]
