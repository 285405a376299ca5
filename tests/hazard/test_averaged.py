"""One path by several models."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.hazard import rows
from avahazard.hazard.exceedance import exceeded_runout
from avahazard.hazard.extremes import EventVolumes
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.rows import Scenario, Weighted
from tests.hazard.parabola import draws, path, path_rows

VOLUME, PERIOD, N = 2e4, 100.0, 400


def by(sigma: float) -> PathHazard:
    coordinates = draws(sigma, N)
    coordinates[:, 0] += np.random.default_rng(0).normal(0.0, 0.05, N)
    volumes = EventVolumes(np.full(N, 0.5), np.log([1e4, 5e4]), np.full((N, 2), 0.5))
    return path(coordinates, volumes, at=[VOLUME])


NARROW, WIDE = by(0.05), by(0.1)
SCENARIOS = [Scenario("p", VOLUME, PERIOD), Scenario("p", VOLUME)]


def averaged(weight: float) -> list:
    models = [Weighted("narrow", weight, NARROW), Weighted("wide", 1.0 - weight, WIDE)]
    return rows.path_rows(models, SCENARIOS, 20_000, 0)


def test_a_model_with_all_the_weight_says_what_it_says_alone() -> None:
    alone, all_of_it = path_rows(WIDE, SCENARIOS, 20_000, 0), averaged(0.0)
    for one, row in zip(alone, all_of_it, strict=True):
        assert row.runout_x_m == one.runout_x_m
        assert row.natural is None
    chances = (each[0].reach.p_per_year.q50 for each in (alone, all_of_it))
    np.testing.assert_allclose(*chances, rtol=0.02, atol=1e-6)
    assert all_of_it[0].design.runout_x_m == alone[0].design.runout_x_m
    assert "not knowing which model is right" in all_of_it[0].design.interval
    assert "not knowing which model is right" not in alone[0].design.interval


def test_quantiles_are_those_of_the_mixture_of_all_draws() -> None:
    row, given = averaged(0.3)
    x = [np.sort(exceeded_runout(one.avalanches, PERIOD)) for one in (NARROW, WIDE)]
    places = np.linspace(*np.quantile(np.concatenate(x), [0.0, 1.0]), 4001)
    below = [np.searchsorted(each, places, side="right") / len(each) for each in x]
    mixed = 0.3 * below[0] + 0.7 * below[1]
    for q, place in ((0.05, row.design.runout_x_m.q05), (0.95, row.design.runout_x_m.q95)):
        assert place == pytest.approx(float(np.interp(q, mixed, places)), abs=3.0)
    assert [(m.model, m.weight) for m in row.by_model] == [("narrow", 0.3), ("wide", 0.7)]
    narrow, wide = (m.runout_x_m.q50 for m in row.by_model)
    assert narrow < row.design.runout_x_m.q50 < wide
    narrow, wide = (m.runout_x_m for m in given.by_model)
    assert narrow.q95 < given.runout_x_m.q95 < wide.q95


def test_its_annual_chance_is_the_mixture_of_their_chances() -> None:
    narrow, wide = (path_rows(one, SCENARIOS, 200, 0)[0].reach for one in (NARROW, WIDE))
    mixed = averaged(0.5)[0].reach.p_per_year
    low = np.minimum(narrow.p_per_year.q05, wide.p_per_year.q05)
    high = np.maximum(narrow.p_per_year.q95, wide.p_per_year.q95)
    assert np.all(np.array(mixed.q05) >= low - 1e-12)
    assert np.all(np.array(mixed.q95) <= high + 1e-12)
