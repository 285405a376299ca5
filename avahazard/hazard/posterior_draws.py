"""Posterior draws of a model for one path, and the runs of its block for groups of like draws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.effect import ShiftEffect
from avahazard.inference.likelihood.block_runs import BlockRuns, Values, run_blocks
from avahazard.inference.likelihood.predicted import Predicted, predict_records
from avahazard.inference.model.observations import Observations
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.prediction.table_groups import table_groups

Indices = NDArray[np.int64]

MAX_TABLES = 32
"""Sets of tables that are run where effects on the motion have parameters."""


@dataclass(frozen=True, slots=True, eq=False)
class GroupRuns:
    """Runs of the block, one for each group of draws that are alike in what shapes its motion.

    `members` are the draws of each group, `values` the effects' parameters that it is run with.
    """

    members: tuple[Indices, ...]
    values: tuple[Values, ...]
    runs: tuple[BlockRuns, ...]


@dataclass(frozen=True, slots=True, eq=False)
class PosteriorDraws:
    """Draws `u` `[n_parameters, n_slots]`, in the order of their groups `group` `[n_parameters]`.

    `offset` `[n_parameters]` of log friction is the path's, None where the model does not know
    it; `tau` `[n_parameters]` the spread between paths, None without one; `sigma_m` as in
    `FittedModel`.
    """

    u: Floats
    group: Indices
    offset: Floats | None
    tau: Floats | None
    sigma_m: Floats | None

    def shift(self, rng: np.random.Generator) -> Floats:
        """Offset of the path's log friction `[n_parameters]`; one is drawn where it has none."""
        if self.offset is not None:
            return self.offset
        if self.tau is None:
            return np.zeros(len(self.u))
        return np.asarray(self.tau * rng.standard_normal(len(self.tau)))


def group_runs(model: FittedModel) -> GroupRuns:
    """Run the block for all draws of a model, each group at its median effects on the motion."""
    layout, draws = model.posterior.layout, model.draws
    shaping = list(layout.tables)
    members = tuple(table_groups(draws[:, shaping], MAX_TABLES))
    values = []
    for group in members:
        middle = draws[group[0]].copy()
        middle[shaping] = np.median(draws[group][:, shaping], axis=0)
        values.append(layout.effect_values(middle))
    curvature = float(model.specification.centrifugal)
    runs = [run_blocks(model.observations, model.posterior.effects, v, curvature) for v in values]
    return GroupRuns(members, tuple(values), tuple(runs))


def group_tables(
    model: FittedModel, groups: GroupRuns, observations: Observations
) -> tuple[Predicted, ...]:
    """Stops of `observations`, which start where those of the model do, by the runs of each group.

    What shifts records alone is left out: bounds are of true stops.
    """
    effects = tuple(e for e in model.posterior.effects if not isinstance(e, ShiftEffect))
    curvature = float(model.specification.centrifugal)
    return tuple(
        predict_records(observations, effects, values, curvature, runs)
        for values, runs in zip(groups.values, groups.runs, strict=True)
    )


def posterior_draws(
    model: FittedModel, groups: GroupRuns, path_id: str, n_parameters: int
) -> PosteriorDraws:
    """At most `n_parameters` of the draws of a model, taken evenly, for a path."""
    order = np.concatenate(groups.members)
    group = np.repeat(np.arange(len(groups.members)), [len(m) for m in groups.members])
    taken = np.isin(order, model.evenly(min(len(order), n_parameters)))
    chosen = order[taken]
    u = model.draws[chosen]
    plan = model.posterior.plan
    # The paths', if any: winters and storms do not last.
    lasting = [g for g, stays in enumerate(plan.lasting) if stays]
    tau = model.posterior.layout.spread_values(u)[:, lasting]
    offset = model.offsets.get(path_id)
    return PosteriorDraws(
        u=u,
        group=group[taken],
        offset=None if offset is None else offset[chosen],
        tau=np.sqrt(np.sum(tau**2, axis=1)) if lasting else None,
        sigma_m=None if model.sigma_m is None else model.sigma_m[chosen],
    )
