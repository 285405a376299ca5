"""The view of one path."""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Event, Path, Profile
from avahazard.results.terrain import PathCheck, Stretch
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.path import describe_path, stretches, view_path
from tests.workflow.worlds import bowl, height


def _describe(records):
    profile = records.profiles[0]
    smooth = smooth_profile(profile.x_m, profile.y_m)
    return describe_path(records.paths[0], profile, smooth, list(records.events))


def _of_points(x, y, sigma: float | None = None) -> PathCheck:
    given = None if sigma is None else np.full(len(x), sigma)
    profile = Profile("B", x, y, elevation_sigma_m=given)
    return describe_path(Path("B"), profile, smooth_profile(x, y, given), [])


def test_a_bowl_that_falls_all_the_way() -> None:
    document = _describe(bowl(1900.0))
    assert document.fit.method == "spline"
    assert document.fit.rms_m < document.fit.elevation_sigma_m == pytest.approx(0.1)
    assert document.monotone is True
    assert document.rises == document.notes == ()
    assert (document.length_m, document.n_points) == (1900.0, 96)
    assert document.drop_m == pytest.approx(798.0)


def test_where_it_rises_and_how_sharply_it_bends() -> None:
    document = _describe(bowl(2400.0))
    assert document.monotone is False
    (rise,) = document.rises
    assert rise.from_x_m == pytest.approx(2000.0, abs=10.0)
    assert rise.to_x_m == 2400.0
    assert document.min_curvature_radius_m == pytest.approx(2500.0, rel=0.05)
    assert "rises at x = " in document.notes[0]


def test_a_flow_longer_than_the_radius_is_told() -> None:
    flow = tuple(Event(str(n), "B", runout_x_m=9.0, deposit_length_m=n) for n in (10, 2700, 9000))
    document = _describe(bowl(2400.0, flow))
    assert document.flow_length_m == 2700.0
    (bend,) = document.sharp_bends
    # (1 + f'²)^1.5 = 2700 / 2500 at both ends.
    half_width = np.sqrt((2700.0 / 2500.0) ** (2.0 / 3.0) - 1.0) / 4e-4
    assert bend.from_x_m == pytest.approx(2000.0 - half_width, abs=15.0)
    assert "below the length of the flow (2700 m)" in document.notes[1]


def test_a_step_is_felt_as_the_block_feels_it() -> None:
    x = np.linspace(0.0, 2000.0, 101)
    y = 1000.0 - 0.4 * x - 60.0 * np.tanh((x - 1000.0) / 30.0)
    fit = _of_points(x, y).fit
    assert (fit.method, fit.degree, fit.sigma_from) == ("spline", None, "estimated")
    assert fit.polynomial_rms_m > 5.0
    # A cliff shorter than the block is rounded off.
    assert fit.elevation_sigma_m < fit.rms_m < 2.0 < fit.max_deviation_m < 10.0
    assert fit.block_m == 100.0


def test_noise_is_told_from_ground() -> None:
    x = np.linspace(0.0, 1900.0, 191)
    y = height(x) + np.random.default_rng(1).normal(0.0, 4.0, 191)
    check = _of_points(x, y)
    assert check.fit.elevation_sigma_m == pytest.approx(4.0, rel=0.15)
    assert check.fit.rms_m == pytest.approx(check.fit.elevation_sigma_m, rel=0.1)
    assert check.fit.ground_sd_m is not None
    assert 0.3 < check.fit.ground_sd_m < 2.0
    assert check.notes == ()


def test_a_stated_error_that_the_points_contradict_is_told() -> None:
    x = np.linspace(0.0, 1900.0, 191)
    y = height(x) + np.random.default_rng(1).normal(0.0, 4.0, 191)
    assert "scatter by" in _of_points(x, y, 1.0).notes[0]
    assert not any("scatter by" in note for note in _of_points(x, y, 4.0).notes)


def test_few_points_are_told() -> None:
    x = np.linspace(0.0, 1900.0, 8)
    assert "8 points do not give their error" in _of_points(x, height(x)).notes[0]


def test_stretches_equal_the_slow_twin() -> None:
    rng = np.random.default_rng(5)
    x = np.cumsum(rng.random(200))
    holds = rng.random(200) < 0.6
    slow, start = [], None
    for i in range(200):
        if holds[i] and start is None:
            start = x[i]
        if holds[i] and (i == 199 or not holds[i + 1]):
            slow.append(Stretch(start, x[i]))
            start = None
    assert stretches(x, holds) == tuple(slow)


def test_the_picture_has_all_that_is_known(database: str, tmp_path: FilePath) -> None:
    events = (
        Event("a", "B", runout_x_m=1500.0, release_elevation_m=900.0),
        Event("b", "B", runout_elevation_m=400.0),
        Event("c", "B", left_profile=True),
    )
    with writing(database) as session:
        save_records(session, bowl(1900.0, events))
    view_path(database, "B", tmp_path / "path.svg")
    drawn = (tmp_path / "path.svg").read_text(encoding="utf-8")
    assert "<svg" in drawn
    assert drawn.count("<use") > 96
