"""How the scores of a model change from its parent's: the fall of the error and its interval."""

from dataclasses import replace

import numpy as np
from scipy.special import stdtrit

from avahazard.results.comparison import BeforeAndAfter, Comparison, ErrorFall, Standing

FEWEST_GROUPS = 3


def before_and_after(before: Comparison | None, after: Comparison) -> BeforeAndAfter:
    """The scores of a parent, None where it was not compared, beside its child's."""
    found = BeforeAndAfter(None, standing(after), after.held_out.by, after.coordinate)
    if before is None:
        return found
    parent, alike = standing(before), after.held_out.parent_crps_m
    if alike is not None:
        parent = replace(parent, held_out_crps_m=alike)
    return replace(found, before=parent, fall=error_fall(before, after))


def standing(found: Comparison) -> Standing:
    """The scores of a comparison by which models are ranked."""
    scores, held_out = found.scores, found.held_out
    runout, speed = scores.runout, scores.speed
    return Standing(
        rmse_m=runout.rmse_m,
        crps_m=runout.crps_m,
        held_out_rmse_m=held_out.runout.rmse_m,
        held_out_crps_m=held_out.runout.crps_m,
        held_out_elpd=held_out.elpd_loo,
        elpd_loo=scores.elpd_loo,
        elpd_loo_se=scores.elpd_loo_se,
        coverage_90=runout.coverage_90,
        speed_rmse_m_s=None if speed is None else speed.rmse_m_s,
        noise_floor_m=runout.noise_floor_m,
        noise_floor_crps_m=runout.noise_floor_crps_m,
        held_out_crps_x_m=None if held_out.runout_x is None else held_out.runout_x.crps_m,
    )


def error_fall(before: Comparison, after: Comparison) -> ErrorFall | None:
    """The fall of the held-out error, with its 90 % interval; None where it has none.

    The two are paired by groups, whose events are not independent: the jackknife over groups, and
    Student's t with one degree of freedom less than there are groups.
    """
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
