"""Posterior draws of a model, with the tables of its block for groups of like draws."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.likelihood.predicted import Predicted, Values, predict_records
from avahazard.inference.model.layout import PATH_SCATTER
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.prediction.table_groups import table_groups

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MAX_TABLES = 32
"""Sets of tables that are run where effects on the motion have parameters."""


@dataclass(frozen=True, slots=True, eq=False)
class PosteriorDraws:
    """Draws `u` `[n_parameters, n_slots]`, in the order of groups that end at `ends`.

    `tables` and `values` are the runs of the block and the effects' parameters of each group;
    `tau` `[n_parameters]` is the spread between paths, None without one; `offsets`
    `[n_parameters]` of log friction by path; `sigma_m` as in `FittedModel`.
    """

    u: Floats
    ends: Indices
    tables: tuple[Predicted, ...]
    values: tuple[Values, ...]
    tau: Floats | None
    offsets: dict[str, Floats]
    sigma_m: Floats | None

    @property
    def group(self) -> Indices:
        """The group of each draw `[n_parameters]`."""
        return np.searchsorted(self.ends, np.arange(len(self.u)), side="right").astype(np.int64)

    def path_shift(self, path_id: str, rng: np.random.Generator) -> Floats:
        """Offset of log friction of a path `[n_parameters]`; one is drawn where it has none."""
        if path_id in self.offsets:
            return self.offsets[path_id]
        if self.tau is None:
            return np.zeros(len(self.u))
        return np.asarray(self.tau * rng.standard_normal(len(self.tau)))


def posterior_draws(model: FittedModel, n_parameters: int) -> PosteriorDraws:
    """Take at most `n_parameters` of the draws of a model evenly, and run the block.

    What shifts records alone is left out: bounds
    are of true stops.
    """
    posterior, layout, coordinates = model.posterior, model.posterior.layout, model.draws
    chosen = model.evenly(min(len(coordinates), n_parameters))
    shaping = list(layout.tables)
    groups = table_groups(coordinates[chosen][:, shaping], MAX_TABLES)
    chosen = chosen[np.concatenate(groups)]
    u = coordinates[chosen]
    effects = tuple(replace(effect, shift=None) for effect in posterior.effects)
    ends = np.cumsum([len(group) for group in groups])
    tables, values = [], []
    for first, last in zip(np.concatenate([[0], ends[:-1]]), ends, strict=True):
        middle = u[first].copy()
        middle[shaping] = np.median(u[first:last, shaping], axis=0)
        values.append(layout.effect_values(middle))
        curvature = float(posterior.specification.centrifugal)
        tables.append(predict_records(posterior.observations, effects, values[-1], curvature))
    tau = None if layout.path_scatter is None else PATH_SCATTER * u[:, layout.path_scatter]
    return PosteriorDraws(
        u=u,
        ends=ends,
        tables=tuple(tables),
        values=tuple(values),
        tau=tau,
        offsets={path_id: draws[chosen] for path_id, draws in model.offsets.items()},
        sigma_m=None if model.sigma_m is None else model.sigma_m[chosen],
    )
