"""Groupings of events, as models have them: by path, and none."""

from __future__ import annotations

import numpy as np

from avahazard.criticism.screening.parametric_bootstrap import GroupSpreads
from avahazard.effects.catalogue import definition
from avahazard.inference.model.friction_model import OffsetPlan, offset_plan
from avahazard.inference.model.observations import Observations


def plan_of(observations: Observations, *keys: str) -> OffsetPlan:
    """The groupings by these effects."""
    columns, sites = observations.columns, observations.sites
    effects = [definition(k).build(definition(k).facts(columns, sites)) for k in keys]
    return offset_plan(effects, columns)


def spreads(observations: Observations, *keys: str, tau: float = 0.0) -> GroupSpreads:
    """These groupings, whose offsets are known to have spread τ."""
    n = len(keys)
    return GroupSpreads(
        plan_of(observations, *keys), np.full(n, tau), np.full((3, n), tau), np.full(n, 0.2)
    )
