"""By how much the error falls from one model to another, and how sure that is."""

from __future__ import annotations

import numpy as np

from avahazard.criticism.scoring.held_out import HeldOut, HeldOutPredictions
from avahazard.criticism.scoring.scores import crps
from avahazard.inference.model.observations import Observations
from avahazard.results.base import Rows
from avahazard.results.comparison import Comparison, GroupError
from avahazard.results.ladder import ErrorFall

FEWEST_GROUPS = 3


def group_errors(
    held: HeldOut, others: HeldOutPredictions, observations: Observations
) -> Rows[GroupError]:
    """Mean CRPS (m) of each path or fold, held out."""
    error = crps(others.records.draws, others.records.observed)
    rows = []
    for group in np.unique(held.groups):
        mine = held.groups == group
        named = held.by == "path" and group >= 0
        name = observations.columns.paths[group] if named else str(int(group))
        rows.append(GroupError(name, int(np.sum(mine)), float(np.mean(error[mine]))))
    return Rows(rows)


def error_fall(before: Comparison, after: Comparison) -> ErrorFall | None:
    """The fall of the held-out error, with its 90 % interval; None where it has none.

    The two are paired by groups, whose events are not independent: the jackknife over groups, and
    Student's t with one degree of freedom less than there are groups.
    """
    from scipy.special import stdtrit  # noqa: PLC0415

    first = {row.group: row for row in before.held_out.groups}
    pairs = [(first[row.group], row) for row in after.held_out.groups if row.group in first]
    if len(pairs) < max(FEWEST_GROUPS, len(first)) or any(a.n != b.n for a, b in pairs):
        return None
    n = np.array([b.n for _, b in pairs], dtype=float)
    sums = n * np.array([a.crps_m - b.crps_m for a, b in pairs])
    fall = float(np.sum(sums) / np.sum(n))
    without = (np.sum(sums) - sums) / (np.sum(n) - n)
    groups = len(pairs)
    se = float(np.sqrt((groups - 1) / groups * np.sum((without - np.mean(without)) ** 2)))
    reach = float(stdtrit(groups - 1, 0.95)) * se
    return ErrorFall(fall, fall - reach, fall + reach)
