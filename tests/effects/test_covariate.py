"""Friction along any column."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from avahazard.effects.covariate import covariate, number_column, ratios_to_volume, spline_columns
from avahazard.effects.effect import FrictionEffect
from avahazard.records.collection import Event
from tests.effects.event_table import event_table
from tests.effects.examples import columns, sites

KNOTS = np.array([1.0, 2.0, 4.0, 5.0, 8.0])


def test_the_first_column_is_the_line() -> None:
    values = np.linspace(-3.0, 12.0, 40)
    assert spline_columns(values, KNOTS, 4.0, 2.0)[:, 0] == pytest.approx((values - 4.0) / 2.0)


def test_bends_are_cubic_between_knots_and_straight_beyond() -> None:
    """A natural spline: no bend at the ends, and a smooth second derivative."""
    step = 1e-3
    values = np.arange(-1.0, 10.0, step)
    columns_ = spline_columns(values, KNOTS, 4.0, 2.0)
    assert columns_.shape[1] == 4
    second = np.diff(columns_, 2, axis=0) / step**2
    at = values[1:-1]
    outside = (at < KNOTS[0] - step) | (at > KNOTS[-1] + step)
    assert np.max(np.abs(second[outside])) < 1e-5
    # Piecewise linear second derivatives: their own second differences sit at the knots only.
    kinks = np.abs(np.diff(second, 2, axis=0)).max(axis=1)
    away = np.min(np.abs(at[1:-1, None] - KNOTS), axis=1) > 3 * step
    assert np.max(kinks[away]) < 1e-4
    assert np.all(np.max(np.abs(second), axis=0)[1:] > 0.1)


def test_the_natural_spline_through_points_is_in_their_span() -> None:
    heights = np.array([0.3, -0.2, 0.5, 0.4, -0.1])
    spline = CubicSpline(KNOTS, heights, bc_type="natural")
    values = np.linspace(1.0, 8.0, 50)
    basis = np.column_stack([np.ones(50), spline_columns(values, KNOTS, 4.0, 2.0)])
    fitted = basis @ np.linalg.lstsq(basis, spline(values), rcond=None)[0]
    assert fitted == pytest.approx(spline(values), abs=1e-10)


def test_a_column_of_numbers_becomes_a_curve_of_order_one() -> None:
    entry, table = covariate("wind"), columns()
    effect = entry.build(entry.facts(table, sites()))
    assert [p.name for p in effect.parameters] == ["slope", "bend_1", "bend_2", "bend_3"]
    assert isinstance(effect, FrictionEffect)
    design = effect.design(table)
    assert design[:, 0].mean() == pytest.approx(0.0, abs=1e-12)
    assert design[:, 0].std() == pytest.approx(1.0)
    line = np.column_stack([np.ones(len(design)), design[:, 0]])
    bends = design[:, 1:]
    departures = bends - line @ np.linalg.lstsq(line, bends, rcond=None)[0]
    assert np.all((departures.std(axis=0) > 0.3) & (departures.std(axis=0) < 5.0))


def test_a_missing_value_counts_as_the_mean() -> None:
    entry = covariate("wind")
    effect = entry.build(entry.facts(columns(), sites()))
    assert isinstance(effect, FrictionEffect)
    mean = float(np.mean(columns().numbers["wind"]))
    gap, middle = (
        columns((Event("g", "P0", covariates=c), Event("z", "P0", covariates={"wind": 9.0})))
        for c in ({}, {"wind": mean})
    )
    assert effect.design(gap) == pytest.approx(effect.design(middle))
    without = columns((Event("g", "P0"),))
    assert np.array_equal(effect.design(without), np.zeros((1, 4)))


def test_a_column_of_text_has_levels() -> None:
    entry = covariate("snow_type")
    effect = entry.build(entry.facts(columns(), sites()))
    assert [p.name for p in effect.parameters] == ["mixed", "wet"]


def test_a_column_of_two_numbers_has_levels() -> None:
    split = columns(
        tuple(Event(str(i), "P0", covariates={"dammed": float(i % 3 == 0)}) for i in range(30))
    )
    entry = covariate("dammed")
    assert entry.lacking(split, ()) is None
    assert entry.facts(split, ()) == {"reference": "0", "levels": ["1"], "prior_sd": 0.2}


def test_columns_of_the_forms_are_known_by_their_names() -> None:
    table = columns()
    assert number_column(table, "volume_m3") is table.log_volume
    assert number_column(table, "year") is table.year
    assert number_column(table, "aspect") is table.numbers["aspect"]
    assert number_column(table, "snow_type") is None


def test_the_volume_over_a_column_is_the_log_of_their_ratio() -> None:
    depth = [0.5, 2.0, np.nan, 1.0, 1.0, 0.8]
    table = replace(
        event_table(depth_m=depth, warmth=[-1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
        log_volume=np.log([1e3, 2e4, 5e4, 1e4, 3e3, 8e4]),
    )
    assert "volume_m3_per_depth_m" in ratios_to_volume(table)
    assert "volume_m3_per_warmth" not in ratios_to_volume(table)
    found = number_column(table, "volume_m3_per_depth_m")
    assert found is not None
    np.testing.assert_allclose(np.exp(found), [2e3, 1e4, np.nan, 1e4, 3e3, 1e5])
    assert number_column(table, "volume_m3_per_warmth_of_snow") is None
    entry = covariate("volume_m3_per_depth_m")
    assert entry.uses_volume
    assert entry.beyond > covariate("depth_m").beyond


def test_one_value_tells_nothing() -> None:
    same = columns(tuple(Event(str(i), "P0", covariates={"wind": 3.0}) for i in range(30)))
    assert "no two values" in str(covariate("wind").lacking(same, ()))
    few = columns(tuple(Event(str(i), "P0", covariates={"wind": float(i)}) for i in range(9)))
    assert covariate("wind").lacking(few, ()) is not None
