"""Where the error of a model comes from: the records, their volumes, nature, the parameters.

Ancey (2005) sets |δy| + |F' δμ| against the misfit and finds that the model errs three times as
much as the data. Here each part is a variance, so that they add up. What a source does to the
runout is not straight (F bends), so its part is that of Shapley: the variance that it adds, on
average over the orders in which sources can be added (Owen 2014). That needs draws that differ in
some sources alone (Song, Nelson & Staum 2016).
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.scores import mean_record_sigma, with_profile
from avahazard.inference.fitted_model import FittedModel, table_groups
from avahazard.inference.model.friction_model import draws as scatter_draws
from avahazard.inference.model.friction_model import friction as drawn
from avahazard.inference.model.friction_model import shifted
from avahazard.inference.model.observations import LEFT, Observations
from avahazard.inference.model.volumes import drawn_log_volumes
from avahazard.inference.prediction import DRAWS_AT_ONCE, group_shift, look_up
from avahazard.results.base import Rows
from avahazard.results.comparison import BudgetPart, Comparison, EventBudget

N_DRAWS = 600
N_TABLES = 12
CHANCE = 1.64
"""Standard errors that chance exceeds in one of twenty cases."""
UNEXPLAINED = "unexplained"


class ErrorBudget(NamedTuple):
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
        return self.record + self.volume + self.release + self.scatter + self.parameters

    @property
    def floor(self) -> Floats:
        """What a model that is exact would leave `[n_events]` (m): record, volume, release."""
        return np.sqrt(self.record + self.volume + self.release)


SOURCES = ErrorBudget._fields


def error_budget(model: FittedModel, rng: np.random.Generator) -> ErrorBudget:
    """The parts of the error of every event of the model that are known beforehand."""
    observations = model.observations
    runout = observations.as_recorded(_runouts(model, rng))
    cost = {
        differ: 0.5 * np.mean((runout[0, 0, 0] - runout[differ]) ** 2, axis=1)
        for differ in np.ndindex(2, 2, 2)
    }
    # Where a source does next to nothing, its part can be drawn below zero.
    parameters, volume, scatter = np.maximum(_shapley(cost), 0.0)
    told = np.where(observations.kind == LEFT, 0.0, mean_record_sigma(model)) ** 2
    # The error of a record holds that of its release; an effect on it scales both.
    release = told * (observations.release_sigma / observations.sigma) ** 2
    return ErrorBudget(told - release, volume, release, scatter, parameters)


def unexplained(error: Floats, budget: ErrorBudget) -> float:
    """Root (m) of the mean square of `error` over that expected; 0 where chance may do as much."""
    more = np.square(error) - budget.expected
    chance = CHANCE * float(np.std(more)) / np.sqrt(len(more))
    return float(np.sqrt(np.mean(more))) if np.mean(more) > chance else 0.0


def _shapley(cost: dict[tuple[int, ...], Floats]) -> Floats:
    """The parts `[3, n_events]` of parameters, volume, scatter in what sets of them cause."""
    parts = np.zeros((3, len(cost[0, 0, 0])))
    orders = list(permutations(range(3)))
    for order in orders:
        differ = [0, 0, 0]
        for source in order:
            before = cost[tuple(differ)]
            differ[source] = 1
            parts[source] += (cost[tuple(differ)] - before) / len(orders)
    return parts


def _runouts(model: FittedModel, rng: np.random.Generator) -> Floats:
    """Runouts `[2, 2, 2, n_events, n_draws]` of the parameters, volume, scatter of either draw.

    In the coordinate of each record; a runout beyond the profile counts as its end.
    """
    posterior = model.posterior
    n = model.observations.n_events
    chosen = model.thinned(N_DRAWS)
    tables_at = model.draws[chosen][:, list(posterior.layout.tables)]
    groups = table_groups(tables_at, N_TABLES)
    group_of = np.empty(N_DRAWS, dtype=np.int64)
    for g, members in enumerate(groups):
        group_of[members] = g
    # The draw of parameters that each draw is set against.
    used = np.stack([np.arange(N_DRAWS), rng.permutation(N_DRAWS)])
    volume_noise = rng.standard_normal((2, N_DRAWS, n))
    noise = scatter_draws(rng, (2, N_DRAWS, n), posterior.friction.student)
    one_kind = posterior.layout.kinds is None
    kind_chance = noise if one_kind else rng.uniform(size=noise.shape)
    in_log = posterior.layout.log_scatter
    friction = np.empty((2, 2, 2, n, N_DRAWS))
    for side, d in np.ndindex(used.shape):
        k = int(chosen[used[side, d]])
        u = model.draws[k]
        shift = group_shift(model, u, k, rng)
        volumes = posterior.volumes(u)
        log_volume = drawn_log_volumes(volumes, volume_noise[:, d])
        location, scatter = posterior.friction.location_and_scatter(
            u, np.exp(log_volume.T), posterior.of_events
        )
        location = shifted(location, shift[:, None], in_log)
        kinds = posterior.friction.kinds(u)
        for v, e in np.ndindex(2, 2):
            deviation, middle = scatter[:, v] * noise[e, d], location[:, v]
            if kinds is not None:
                middle = shifted(middle, kinds.drawn(kind_chance[e, d]), in_log)
            friction[side, v, e, :, d] = drawn(middle, deviation, in_log)
    del volume_noise, noise, kind_chance
    # A friction gives way to its runout: there are eight of them to a draw and event.
    runout = friction
    for g, members in enumerate(groups):
        away = np.sum((tables_at[members] - tables_at[members].mean(axis=0)) ** 2, axis=1)
        tables = posterior.nodes.predicted_at(model.draws[chosen[members[np.argmin(away)]]])
        for side in range(2):
            selected = np.flatnonzero(group_of[used[side]] == g)
            for some in np.array_split(selected, 1 + len(selected) // DRAWS_AT_ONCE):
                for v, e in np.ndindex(2, 2):
                    runout[side, v, e][:, some] = look_up(tables, friction[side, v, e][:, some])[0]
    return runout


def budget_parts(error: Floats, budget: ErrorBudget) -> Rows[BudgetPart]:
    """Root mean squares (m) of every source, the release if it has errors, and what is left."""
    parts = [
        BudgetPart(source, float(np.sqrt(np.mean(variance))))
        for source, variance in budget._asdict().items()
        if source != "release" or np.any(variance > 0.0)
    ]
    return Rows([*parts, BudgetPart(UNEXPLAINED, unexplained(error, budget))])


def budget_by_event(
    observations: Observations, error: Floats, budget: ErrorBudget, profile: Floats
) -> Rows[EventBudget]:
    """Of each event the sd by source, its error, and what errors of the `profile` do (m)."""
    sd = {f"{source}_m": np.sqrt(variance) for source, variance in budget._asdict().items()}
    sd["profile_m"] = profile
    return Rows(
        EventBudget(name, error_m=float(error[i]), **{key: float(v[i]) for key, v in sd.items()})
        for i, name in enumerate(observations.columns.event_id)
    )


def profile_part(observations: Observations, profile: Floats) -> float | None:
    """Root mean square (m) of `profile` `[n_events]` over events with a profile, None if none."""
    on_ground = with_profile(observations)
    return float(np.sqrt(np.mean(profile[on_ground] ** 2))) if len(on_ground) else None


def with_explained(
    child: Comparison, parent: Comparison | None, added: Sequence[str]
) -> Comparison:
    """The comparison of a model whose budget counts what its effects have explained.

    That is by how much the mean square of the error fell from its parent, which was compared with
    the same records; so the squares add up to those of the first model of the line.
    """
    if parent is None or not added or parent.scores.runout.n != child.scores.runout.n:
        return child
    before, after = parent.scores.runout.rmse_m, child.scores.runout.rmse_m
    fallen = float(np.sqrt(max(before**2 - after**2, 0.0)))
    sources = (*SOURCES, UNEXPLAINED)
    earlier = [part for part in parent.budget if part.source not in sources]
    own = [part for part in child.budget if part.source in sources]
    gained = [*earlier, BudgetPart("+".join(added), fallen)]
    return replace(child, budget=Rows([*own[:-1], *gained, own[-1]]))
