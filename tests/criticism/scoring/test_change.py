"""The fall of an error and its interval, against data with a known fall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.scoring.change import before_and_after, error_fall
from avahazard.criticism.scoring.error_budget import with_explained
from avahazard.results.base import Rows
from avahazard.results.comparison import (
    BudgetPart,
    Comparison,
    GroupError,
    HeldOutScores,
    RunoutScores,
    Scores,
)


def comparison(errors: list[float], sizes: list[int], rmse: float = 10.0) -> Comparison:
    groups = Rows(
        GroupError(f"P{k}", n, e) for k, (e, n) in enumerate(zip(errors, sizes, strict=True))
    )
    runout = RunoutScores(sum(sizes), rmse, 0.0, 5.0, 0.5, 0.9, 1.0, 0.5, (1,) * 10)
    return Comparison(
        model="m",
        coordinate="elevation",
        scores=Scores(runout, None, None, None, pareto_k_bad=0, pareto_k_refitted=0),
        held_out=HeldOutScores(runout, None, None, None, by="path", groups=groups),
        where_it_fails=Rows(),
        speed_misfit=None,
        measured_force=None,
        budget=Rows([BudgetPart("record", 3.0), BudgetPart("unexplained", 4.0)]),
    )


def test_it_is_the_weighted_mean_difference() -> None:
    fall = error_fall(
        comparison([20.0, 30.0, 10.0], [10, 5, 5]), comparison([15.0, 20.0, 9.0], [10, 5, 5])
    )
    assert fall is not None
    assert fall.mean_m == pytest.approx((50.0 + 50.0 + 5.0) / 20.0)
    assert fall.q05_m < fall.mean_m < fall.q95_m
    assert fall.mean_m - fall.q05_m == pytest.approx(fall.q95_m - fall.mean_m)


def test_its_interval_holds_the_true_fall_nine_times_in_ten() -> None:
    rng = np.random.default_rng(3)
    held = 0
    for _ in range(400):
        n = rng.integers(5, 30, 8)
        before = rng.normal(50.0, 10.0, 8)
        after = before - rng.normal(4.0, 3.0, 8)
        fall = error_fall(
            comparison(before.tolist(), n.tolist()), comparison(after.tolist(), n.tolist())
        )
        assert fall is not None
        held += fall.q05_m <= 4.0 <= fall.q95_m
    assert 0.84 < held / 400 < 0.94


def test_two_groups_or_other_groups_have_none() -> None:
    assert error_fall(comparison([1.0, 2.0], [3, 3]), comparison([1.0, 1.0], [3, 3])) is None
    first, other = comparison([1.0] * 3, [3] * 3), comparison([1.0] * 3, [3, 3, 4])
    assert error_fall(first, other) is None


def test_what_effects_explain_adds_up_along_the_line() -> None:
    base, child, grandchild = (comparison([1.0] * 3, [3] * 3, rmse) for rmse in (13.0, 12.0, 8.0))
    child = with_explained(child, base, ["forest-drag"])
    assert {p.source: p.rms_m for p in child.budget} == {
        "record": 3.0,
        "forest-drag": pytest.approx(5.0),
        "unexplained": 4.0,
    }
    last = with_explained(grandchild, child, ["season", "snow-type"])
    assert [p.source for p in last.budget] == [
        "record",
        "forest-drag",
        "season+snow-type",
        "unexplained",
    ]
    assert last.budget[2].rms_m == pytest.approx(np.sqrt(144.0 - 64.0))
    worse = with_explained(replace(base), grandchild, ["season"])
    assert worse.budget[1].rms_m == 0.0
    assert with_explained(child, None, ["season"]) is child


def test_a_parent_is_scored_on_the_groups_of_its_child() -> None:
    parent, child = comparison([8.0] * 3, [3] * 3), comparison([5.0] * 4, [2] * 4)
    assert before_and_after(None, child).before is None
    plain = before_and_after(parent, child)
    assert plain.before is not None
    assert plain.before.held_out_crps_m == 5.0
    other = replace(child, held_out=replace(child.held_out, parent_crps_m=4.0))
    found = before_and_after(parent, other)
    assert found.before is not None
    assert (found.before.held_out_crps_m, found.fall, found.worse) == (4.0, None, True)
