"""The view of one path."""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.event import Event
from avahazard.records.path import Profile
from avahazard.results.terrain import Stretch
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.path import describe_path, stretches, view_path
from tests.workflow.worlds import bowl


def _describe(records):
    profile = records.profiles[0]
    smooth = smooth_profile(profile.x_m, profile.y_m)
    return describe_path(records.paths[0], profile, smooth, list(records.events))


def test_a_bowl_that_falls_all_the_way() -> None:
    document = _describe(bowl(1900.0))
    assert document.fit.method == "legendre"
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


def test_a_step_takes_the_spline_and_says_so() -> None:
    x = np.linspace(0.0, 2000.0, 101)
    y = 1000.0 - 0.4 * x - 60.0 * np.tanh((x - 1000.0) / 30.0)
    records = bowl()
    document = describe_path(records.paths[0], Profile("B", x, y), smooth_profile(x, y), [])
    assert document.to_dict()["fit"].keys() == {
        "method",
        "smoothing",
        "polynomial_deviation_m",
        "max_deviation_m",
    }
    assert document.fit.max_deviation_m <= 5.0
    assert document.fit.polynomial_deviation_m > 10.0
    assert "smoothing spline was taken" in document.notes[0]


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
