"""The error budget as rows: in all, by event, and what each added effect has explained."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.error_budget import ErrorBudget, unexplained
from avahazard.criticism.scoring.in_x import with_profile
from avahazard.inference.model.observations import Observations
from avahazard.results.base import Rows
from avahazard.results.comparison import BudgetPart, Comparison, EventBudget

SOURCES = ("record", "volume", "release", "scatter", "parameters")
UNEXPLAINED = "unexplained"


def budget_parts(error: Floats, budget: ErrorBudget) -> Rows[BudgetPart]:
    """Every source and what is left of `error` `[n_events]` (m), as root mean squares.

    The release is one where an error of it is stated.
    """
    parts = [
        BudgetPart(source, float(np.sqrt(np.mean(getattr(budget, source)))))
        for source in SOURCES
        if source != "release" or np.any(budget.release > 0.0)
    ]
    return Rows([*parts, BudgetPart(UNEXPLAINED, unexplained(error, budget))])


def budget_by_event(
    observations: Observations, error: Floats, budget: ErrorBudget, profile: Floats
) -> Rows[EventBudget]:
    """Standard deviations by source of each event, and its error (predicted less recorded).

    `profile` `[n_events]` (m) is what the error of the profile's points does.
    """
    sd = {f"{source}_m": np.sqrt(getattr(budget, source)) for source in SOURCES}
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
