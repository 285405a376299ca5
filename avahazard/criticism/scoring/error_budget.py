"""Where the error of a model comes from: the records, their volumes, nature, the parameters.

Ancey (2005) sets |δy| + |F' δμ| against the misfit and finds that the model errs three times as
much as the data. Here each part is a variance, so that they add up. What a source does to the
runout is not straight (F bends), so its part is that of Shapley: the variance that it adds, on
average over the orders in which sources can be added (Owen 2014). That needs draws that differ in
some sources alone (Song, Nelson & Staum 2016).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.expected import mean_record_sigma
from avahazard.inference.model.friction_scatter import draws as scatter_draws
from avahazard.inference.model.friction_scatter import friction as drawn
from avahazard.inference.model.friction_scatter import shifted
from avahazard.inference.model.observations import LEFT
from avahazard.inference.model.volumes import drawn_log_volumes
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.prediction.stops import DRAWS_AT_ONCE, group_shift, look_up
from avahazard.inference.prediction.table_groups import table_groups

N_DRAWS = 600
N_TABLES = 12
CHANCE = 1.64
"""Standard errors that chance exceeds in one of twenty cases."""
PARAMETERS, VOLUME, SCATTER = 0, 1, 2
SOURCES = (PARAMETERS, VOLUME, SCATTER)


@dataclass(frozen=True, slots=True, eq=False)
class ErrorBudget:
    """Variances (m2) `[n_events]` in the coordinate of each record, by source.

    `record`: its own measurement error; `volume`: that of its volume, through the law and F';
    `release`: that of where it started, through dF/dz₀ (`inference.model.release_error`);
    `scatter`: avalanches of one volume differ; `parameters`: they are known from few records.
    """

    record: Floats
    volume: Floats
    release: Floats
    scatter: Floats
    parameters: Floats

    @property
    def expected(self) -> Floats:
        """What all sources together let expect `[n_events]`, m2."""
        measured = self.record + self.volume + self.release
        return np.asarray(measured + self.scatter + self.parameters)

    @property
    def floor(self) -> Floats:
        """What a model that is exact would leave `[n_events]` (m): record, volume, release."""
        return np.sqrt(self.record + self.volume + self.release)


def error_budget(model: FittedModel, rng: np.random.Generator) -> ErrorBudget:
    """The parts of the error of every event of the model that are known beforehand."""
    observations = model.observations
    runout = observations.as_recorded(_runouts(model, rng))
    cost = {
        differ: 0.5 * np.mean((runout[0, 0, 0] - runout[differ]) ** 2, axis=1)
        for differ in np.ndindex(2, 2, 2)
    }
    # Where a source does next to nothing, its part can be drawn below nought.
    parameters, volume, scatter = np.maximum(_shapley(cost), 0.0)
    told = np.where(observations.kind == LEFT, 0.0, mean_record_sigma(model)) ** 2
    # The error of a record holds that of its release; an effect on it scales both.
    release = told * (observations.release_sigma / observations.sigma) ** 2
    return ErrorBudget(told - release, volume, release, scatter, parameters)


def unexplained(error: Floats, budget: ErrorBudget) -> float:
    """Root (m) of what the mean square of `error` `[n_events]` is over that to be expected.

    0 where it is not over it by more than chance does in one of twenty cases.
    """
    more = np.square(error) - budget.expected
    chance = CHANCE * float(np.std(more)) / np.sqrt(len(more))
    return float(np.sqrt(np.mean(more))) if np.mean(more) > chance else 0.0


def _shapley(cost: dict[tuple[int, ...], Floats]) -> Floats:
    """The part of each source `[n_sources, n_events]` of the variances that sets of them cause."""
    parts = np.zeros((len(SOURCES), len(cost[0, 0, 0])))
    orders = list(permutations(SOURCES))
    for order in orders:
        differ = [0] * len(SOURCES)
        for source in order:
            before = cost[tuple(differ)]
            differ[source] = 1
            parts[source] += (cost[tuple(differ)] - before) / len(orders)
    return parts


def _runouts(model: FittedModel, rng: np.random.Generator) -> Floats:
    """Runouts `[2, 2, 2, n_events, n_draws]` of the parameters, volume, scatter of either draw.

    In the coordinate of each record; what left its profile reached the end.
    """
    posterior = model.posterior
    n = model.observations.n_events
    chosen = model.evenly(N_DRAWS)
    tables_at = model.draws[chosen][:, list(posterior.layout.tables)]
    groups = table_groups(tables_at, N_TABLES)
    group_of = np.empty(N_DRAWS, dtype=np.int64)
    for g, members in enumerate(groups):
        group_of[members] = g
    # The draw of parameters that each draw is set against.
    used = np.stack([np.arange(N_DRAWS), rng.permutation(N_DRAWS)])
    volume_noise = rng.standard_normal((2, N_DRAWS, n))
    student = posterior.specification.tails == "student"
    noise = scatter_draws(rng, (2, N_DRAWS, n), student)
    in_log = posterior.layout.log_scatter
    friction = np.empty((2, 2, 2, n, N_DRAWS))
    for side, d in np.ndindex(used.shape):
        k = int(chosen[used[side, d]])
        u = model.draws[k]
        shift = group_shift(model, u, k, rng)
        volumes = posterior.volumes(u)
        log_volume = drawn_log_volumes(volumes, volume_noise[:, d])
        location, scatter = posterior.location_and_scatter(u, np.exp(log_volume.T))
        location = shifted(location, shift[:, None], in_log)
        for v, e in np.ndindex(2, 2):
            deviation = scatter[:, v] * noise[e, d]
            friction[side, v, e, :, d] = drawn(location[:, v], deviation, in_log)
    del volume_noise, noise
    # A friction gives way to its runout: there are eight of them to a draw and event.
    runout = friction
    for g, members in enumerate(groups):
        away = np.sum((tables_at[members] - tables_at[members].mean(axis=0)) ** 2, axis=1)
        tables = posterior.nodes.predicted_at(model.draws[chosen[members[np.argmin(away)]]])
        for side in range(2):
            mine = np.flatnonzero(group_of[used[side]] == g)
            for some in np.array_split(mine, 1 + len(mine) // DRAWS_AT_ONCE):
                for v, e in np.ndindex(2, 2):
                    runout[side, v, e][:, some] = look_up(tables, friction[side, v, e][:, some])[0]
    return runout
