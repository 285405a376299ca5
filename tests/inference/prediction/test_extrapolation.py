"""Volumes beyond the records, and friction beyond what physics allows, are told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.prediction.extrapolation import extrapolation
from avahazard.inference.prediction.fitted_model import FittedModel, fitted_model
from tests.inference.studies import near, observations, posterior


def _model(n: float, *effects: str, **settings: str) -> FittedModel:
    given = posterior(observations(speeds=False), *effects, **settings)
    first = given.layout.law.coordinates
    u = np.array([near(given, 0.0, k, **{"n in 1e-6/m3": n}) for k in range(400)])
    u[:, 0] += 0.02 * np.random.default_rng(0).standard_normal(400)
    assert first[0] == "log a"
    return fitted_model(given, u, {"P0": np.full(400, 0.1)})


def _largest(model: FittedModel, path_id: str | None = None) -> float:
    columns = model.observations.columns
    known = np.exp(columns.log_volume)
    if path_id is not None:
        known = known[columns.path_index == columns.paths.index(path_id)]
    return float(np.nanmax(known))


def test_within_the_records_nothing_is_said() -> None:
    model = _model(1.0)
    assert extrapolation(model, "P1", _largest(model, "P1")).notes() == []


def test_how_far_beyond_the_path_and_all_paths() -> None:
    model = _model(0.01)
    path = min(model.observations.columns.paths, key=lambda p: _largest(model, p))
    largest, all_paths = _largest(model, path), _largest(model)
    between = extrapolation(model, path, 0.5 * (largest + all_paths))
    assert between.times_path == pytest.approx(0.5 * (1.0 + all_paths / largest))
    assert between.times_all is None
    (note,) = between.notes(path)
    assert note.startswith(f"{path}: ")
    assert "all paths" not in note
    beyond = extrapolation(model, path, 3.0 * all_paths)
    assert beyond.times_all == pytest.approx(3.0)
    assert "and 3 times that of all paths" in beyond.notes()[0]
    unknown = extrapolation(model, "elsewhere", 3.0 * all_paths)
    assert unknown.largest_of_path_m3 is None
    assert "3 times the largest recorded" in unknown.notes()[0]
    far = replace(unknown, volume_m3=1.36e2 * (unknown.largest_m3 or 0.0))
    assert "is 140 times the largest recorded" in far.notes()[0]
    for times, told in ((1.002, "1.01"), (1.032, "1.03"), (1.36, "1.4")):
        barely = replace(unknown, volume_m3=times * (unknown.largest_m3 or 0.0))
        assert f"is {told} times the largest recorded" in barely.notes()[0]


@pytest.mark.parametrize(("n", "side"), [(1.0, "under 0.1"), (-1.0, "over 1.5")])
def test_friction_that_no_avalanche_has_is_loud(n: float, side: str) -> None:
    found = extrapolation(_model(n), "P0", 5e7)
    assert found.too_low + found.too_high == pytest.approx(1.0)
    assert side in found.notes()[-1]
    assert "OUT OF BOUNDS" in found.notes()[-1]


def test_the_bounded_law_stays_within() -> None:
    given = posterior(observations(speeds=False), law="asymptotic")
    u = np.array([near(given) for _ in range(400)])
    found = extrapolation(fitted_model(given, u, {}), "P0", 1e9)
    assert (found.too_low, found.too_high) == (0.0, 0.0)
    assert found.median == pytest.approx(np.exp(-0.8 - 0.5), rel=0.03)
    assert len(found.notes()) == 1


def test_draws_have_the_scatter_and_the_offset_of_the_path() -> None:
    """The share under the limit is that of the normal of log friction."""
    model = _model(0.0, "path-effect")
    u = model.draws.copy()
    u[:, model.posterior.layout.scatter] = np.log(0.6)
    wide = fitted_model(model.posterior, np.repeat(u, 50, axis=0), {"P0": np.full(20000, 0.1)})
    found = extrapolation(wide, "P0", 1e4)
    assert found.median == pytest.approx(np.exp(-0.7), rel=0.02)
    from scipy.stats import norm  # noqa: PLC0415

    expected = norm.cdf((np.log(0.1) + 0.7) / np.hypot(0.6, 0.02))
    assert found.too_low == pytest.approx(expected, abs=0.003)
