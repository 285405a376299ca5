"""Where a model fails, along which axes, and what is chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.special import ndtr

from avahazard.criticism.scoring.where_it_fails import (
    contrast_p,
    contrast_p_values,
    event_axes,
    holm,
    terciles,
    where_it_fails,
)
from avahazard.inference.model.observations import build_observations
from tests.criticism.studies import slopes, straight


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


def test_thirds_are_named_by_their_edges() -> None:
    levels = terciles(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, np.nan]), ".1f")
    assert list(levels) == ["up to 2.7"] * 2 + ["2.7 to 4.3"] * 2 + ["above 4.3"] * 2 + [""]
    assert set(terciles(np.full(4, 7.0), "g")) == {""}


def test_every_axis() -> None:
    records = slopes(n_paths=3)
    paths = tuple(
        replace(p, section="open" if k else "channelled", orientation="NE")
        for k, p in enumerate(records.paths)
    )
    events = tuple(
        replace(
            e,
            date=f"19{50 + k:02d}-{1 + k % 3:02d}-28",
            volume_m3=1e4 * (k + 1),
            covariates={"snow_type": "wet" if k % 2 else "dry", "dust": float(k), "flag": k % 2},
        )
        for k, e in enumerate(records.events)
    )
    cover = tuple("open" if x < 1000.0 else "forest" for x in records.profiles[0].x_m)
    profiles = tuple(replace(p, land_cover=cover) for p in records.profiles)
    observations = build_observations(
        replace(records, paths=paths, events=events, profiles=profiles)
    )
    x = np.linspace(600.0, 1500.0, 18)
    axes = event_axes(observations, x)
    assert all(len(levels) == 18 for levels in axes.values())
    assert list(axes["path"][[0, 6, 12]]) == ["P0", "P1", "P2"]
    assert list(axes["volume"][[0, 17]]) == ["up to 67,000 m3", "above 120,000 m3"]
    assert list(axes["month"][:4]) == ["January", "February", "March", "January"]
    assert axes["year"][0] == "up to 1956"
    assert list(axes["section"][[0, 6]]) == ["channelled", "open"]
    assert set(axes["orientation"]) == {"NE"}
    assert list(axes["snow_type"][:2]) == ["dry", "wet"]
    assert list(axes["flag"][:2]) == ["0", "1"]
    assert axes["dust"][17].startswith("above 11.3")
    place = axes["land_cover_at_predicted_stop"]
    np.testing.assert_array_equal(place == "forest", x >= 1000.0)
    # y falls, and so does the slope, all the way.
    assert axes["predicted_stop_elevation_m"][0].startswith("above")
    assert axes["slope_at_predicted_stop"][17].startswith("up to")
    assert axes["place_along_path"][17].startswith("above")


def test_events_without_a_profile() -> None:
    observations = build_observations(straight(9))
    axes = event_axes(observations, np.full(9, np.nan))
    assert set(axes["path"]) == {""}
    assert set(axes["slope_at_predicted_stop"]) == {""}


PATH = np.repeat(np.arange(9), [40, 10, 25, 8, 30, 15, 22, 12, 18])


def _flags(kind: str, rng: np.random.Generator) -> np.ndarray:
    """Levels that vary within paths, that belong to whole paths, or mostly so."""
    if kind == "events":
        return (rng.random(len(PATH)) < 0.3).astype(float)
    of_path = (rng.permutation(9) < 4).astype(float)[PATH]
    if kind == "paths":
        return of_path
    return np.where(rng.random(len(PATH)) < 0.2, 1.0 - of_path, of_path)


@pytest.mark.parametrize("spread", [0.0, 0.5])
@pytest.mark.parametrize("kind", ["events", "paths", "mixed"])
def test_p_values_of_nothing_are_even(kind: str, spread: float) -> None:
    rng = np.random.default_rng(1)
    found = []
    for _ in range(1500):
        z = rng.standard_normal(len(PATH)) + spread * rng.standard_normal(9)[PATH]
        found.append(contrast_p(z, _flags(kind, rng), PATH))
    p = np.array(found)
    for level in (0.01, 0.05, 0.2):
        # No more alarms than promised, and not far fewer where events of a path differ.
        assert np.mean(p < level) < level + 3.0 * np.sqrt(level / 1500) + 0.15 * level
    if kind == "events":
        assert np.mean(p < 0.2) > 0.13


def test_without_paths_that_differ_it_is_near_the_t_test() -> None:
    rng = np.random.default_rng(2)
    x = _flags("events", rng)
    z = rng.standard_normal(len(PATH)) * 1.2 + 0.4 * x
    p = contrast_p(z, x, PATH)
    assert p == pytest.approx(float(stats.ttest_ind(z[x == 1], z[x == 0]).pvalue), rel=0.5)


def test_whole_paths_are_the_t_test_of_their_means() -> None:
    rng = np.random.default_rng(3)
    path = np.repeat(np.arange(10), 20)
    x = (np.arange(10) < 4).astype(float)
    # A spread so wide that the events within a path say nothing.
    z = rng.standard_normal(200) + (30.0 * rng.standard_normal(10) + 20.0 * x)[path]
    means = np.bincount(path, z) / 20
    expected = stats.ttest_ind(means[x == 1], means[x == 0]).pvalue
    assert contrast_p(z, x[path], path) == pytest.approx(float(expected), rel=1e-3)


def test_a_level_within_paths_is_seen_through_their_spread() -> None:
    rng = np.random.default_rng(4)
    x = _flags("events", rng)
    z = rng.standard_normal(len(PATH)) + 2.0 * rng.standard_normal(9)[PATH] + 0.8 * x
    p = contrast_p(z, x, PATH)
    assert p is not None
    assert p < 1e-4


def test_levels_without_contrast_say_nothing() -> None:
    z = np.arange(6.0)
    assert contrast_p(z, np.ones(6), np.repeat([0, 1], 3)) is None
    of_path = np.array(["a", "a", "b", "b", "c", "c"])
    assert contrast_p_values(z, of_path, np.repeat([0, 1, 2], 2)) == {}
