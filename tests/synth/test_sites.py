"""Made-up and given paths."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.records.reading import read_records
from avahazard.synth.making import make_world
from avahazard.synth.settings import Settings
from avahazard.synth.sites import concave_profile, given_sites, make_sites


@pytest.mark.parametrize("seed", range(5))
def test_paths_look_like_avalanche_paths(seed: int) -> None:
    sites = make_sites(seed, 10, 250)
    assert sum(s.n_events for s in sites) == 250
    assert len({s.n_events for s in sites}) > 3
    assert {s.path.section for s in sites} == {"channelled", "open"}
    for s in sites:
        x, y = s.profile.x_m, s.profile.y_m
        drop = y[0] - y.min()
        assert 580.0 < drop < 2080.0
        assert 1200.0 < x[-1] < 5600.0
        assert (y[0] - y[8]) / x[8] > 0.8
        assert abs((y[-2] - y[-1]) / (x[-1] - x[-2])) < 0.15


def test_profile_has_the_drop_and_the_slopes_asked_for() -> None:
    _, y = concave_profile(1000.0, 2400.0, slopes=(1.0, 0.1), power=1.5)
    assert y[0] == 2400.0
    assert y[-1] == pytest.approx(1400.0, abs=0.1 * 15.0)
    assert (y[0] - y[1]) / 15.0 == pytest.approx(1.0, abs=0.02)
    assert (np.diff(y) < 0.0).all()


def test_given_profiles_are_used_as_they_are(shared_data: Path) -> None:
    tyrol = read_records([shared_data / "tyrol-profiles"])
    sites = given_sites(3, tyrol, 120)
    records, truth = make_world(3, sites=sites, settings=Settings(smooth_m=200.0))
    assert len(records.events) == 120
    assert [p.path_id for p in records.profiles] == [p.path_id for p in tyrol.profiles]
    assert truth["n_paths"] == 9
    left = sum(e.left_profile for e in records.events)
    assert left < 30
    # Each of these profiles rises somewhere, so that an elevation is not one place.
    assert all(e.runout_elevation_m is None for e in records.events)
