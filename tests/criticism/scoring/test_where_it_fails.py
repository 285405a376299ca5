"""Bias by level and its chance."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr

from avahazard.criticism.scoring.where_it_fails import holm, where_it_fails


def test_holm_by_hand() -> None:
    assert holm([0.01, 0.04, 0.03, 0.005], [1.0] * 4) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.9, 0.8], [1.0, 1.0]) == [1.0, 1.0]
    assert holm([], []) == []
    # Ordered by p / w: 0.01 (2.5 left), 0.04 (1.5), 0.06 (0.5 left).
    by_weight = holm([0.03, 0.01, 0.04], [0.5, 1.0, 1.0])
    assert by_weight == pytest.approx([0.06, 0.025, 0.06])


def test_a_column_of_many_words_hides_no_other() -> None:
    rng = np.random.default_rng(5)
    path = np.repeat(np.arange(8), 30)
    z = rng.standard_normal(240)
    wet = np.arange(240) % 3 == 0
    z[wet] += 0.6
    wetness = {"snow_type": np.where(wet, "wet", "dry")}
    observer = np.array([f"observer {k}" for k in rng.integers(0, 30, 240)])
    alone = where_it_fails(wetness, z, ndtr(z), path)
    joined = where_it_fails(wetness | {"observer": observer}, z, ndtr(z), path)
    assert joined[0].level == alone[0].level == "wet"
    assert joined[0].p_value < 2.01 * alone[0].p_value


def test_a_level_that_is_off_is_found_first() -> None:
    rng = np.random.default_rng(1)
    z = rng.standard_normal(200)
    path = np.repeat(np.arange(8), 25)
    wet = np.arange(200) % 4 == 0
    z[wet] += 1.2
    axes = {
        "path": np.array([f"P{p}" for p in path]),
        "snow_type": np.where(wet, "wet", "dry"),
        "decoy": np.where(rng.random(200) < 0.5, "a", "b"),
    }
    rows = where_it_fails(axes, -30.0 * z, ndtr(z), path)
    assert (rows[0].axis, rows[0].level, rows[0].n) == ("snow_type", "wet", 50)
    assert rows[0].p_value < 1e-4
    assert rows[0].bias_m == pytest.approx(-30.0 * z[wet].mean())
    assert [r.p_value for r in rows] == sorted(r.p_value for r in rows)
    assert {r.axis for r in rows} == set(axes)


@pytest.mark.parametrize("spread", [0.0, 0.7])
def test_false_alarms_are_rare_also_where_paths_differ(spread: float) -> None:
    """Section is a property of the path: a spread between paths must not look like it."""
    rng = np.random.default_rng(2)
    path = np.repeat(np.arange(10), 20)
    alarms = 0
    for _ in range(400):
        offset = spread * rng.standard_normal(10)
        z = (rng.standard_normal(200) + offset[path]) / np.hypot(1.0, spread)
        section = np.where(rng.permutation(10)[path] < 5, "open", "channelled")
        month = rng.choice(["January", "February", "March"], 200)
        rows = where_it_fails({"section": section, "month": month}, z, ndtr(z), path)
        alarms += rows[0].p_value < 0.05
    assert alarms / 400 < 0.08


def test_levels_of_one_path_each_say_no_more_than_the_paths() -> None:
    z = np.random.default_rng(3).standard_normal(60)
    path = np.repeat(np.arange(6), 10)
    axes = {"slope": np.array([f"s{p}" for p in path])}
    assert where_it_fails(axes, z, ndtr(z), path) == ()
    # With few paths there is no clustering, and they are looked at like any levels.
    assert len(where_it_fails({"slope": axes["slope"][:40]}, z[:40], ndtr(z[:40]), path[:40])) == 4


def test_small_and_single_levels_are_left_out() -> None:
    z = np.zeros(12)
    path = np.zeros(12, dtype=np.int64)
    axes = {
        "small": np.array(["a"] * 4 + ["b"] * 8),
        "single": np.array(["a"] * 12),
        "unknown": np.array([""] * 6 + ["a"] * 6),
    }
    rows = where_it_fails(axes, z, ndtr(z), path)
    assert [(r.axis, r.level) for r in rows] == [("small", "b")]
