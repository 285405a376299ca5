"""Made-up and given paths."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from avahazard.synth import sites
from avahazard.synth.making import make_world
from avahazard.synth.sites import RUN_ON_M, VALLEY_SLOPE, concave_profile, make_sites


def events_of(truth: dict[str, Any]) -> list[dict[str, Any]]:
    """The true events."""
    return list(truth["events"])


@pytest.mark.parametrize("seed", range(5))
def test_paths_look_like_avalanche_paths(seed: int) -> None:
    made = make_sites(seed, 10, 250)
    assert sum(s.n_events for s in made) == 250
    assert len({s.n_events for s in made}) > 3
    assert {s.path.section for s in made} == {"channelled", "open"}
    for s in made:
        x, y = s.profile.x_m, s.profile.y_m
        assert s.drop_m is not None
        assert 580.0 < s.drop_m < 2080.0
        valley_m = VALLEY_SLOPE * RUN_ON_M
        assert s.drop_m <= y[0] - y.min() < s.drop_m + valley_m + 20.0
        assert 1200.0 < x[-1] - RUN_ON_M < 5600.0
        assert (y[0] - y[8]) / x[8] > 0.8
        assert abs((y[-2] - y[-1]) / (x[-1] - x[-2])) < 0.15


def test_profile_has_the_drop_and_the_slopes_asked_for() -> None:
    _, y = concave_profile(1000.0, 2400.0, slopes=(1.0, 0.1), power=1.5)
    assert y[0] == 2400.0
    assert y[-1] == pytest.approx(1400.0, abs=0.1 * 15.0)
    assert (y[0] - y[1]) / 15.0 == pytest.approx(1.0, abs=0.02)
    assert (np.diff(y) < 0.0).all()


def test_a_longer_end_moves_no_avalanche_that_stopped_before_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    longer, truth = make_world(0, 120, 6)
    monkeypatch.setattr(sites, "_run_on", lambda x, y: (x, y))
    shorter, before = make_world(0, 120, 6)
    stops = list(zip(events_of(truth), events_of(before), strict=True))
    stopped = [(e, f) for e, f in stops if f["status"] == "stopped"]
    assert 100 < len(stopped) < 120
    assert all(abs(e["stop_x_m"] - f["stop_x_m"]) < 1.0 for e, f in stopped)
    assert [e.volume_m3 for e in longer.events] == [e.volume_m3 for e in shorter.events]
    releases = [[e.release_elevation_m or 0.0 for e in w.events] for w in (longer, shorter)]
    assert releases[0] == pytest.approx(releases[1], abs=2.0)
    assert not any(e.left_profile for e in longer.events)


def test_forest_stands_where_it_stood(monkeypatch: pytest.MonkeyPatch) -> None:
    def forest() -> list[list[float]]:
        return [
            [x for x, c in zip(p.x_m, p.land_cover or (), strict=True) if c == "forest"]
            for p in (s.profile for s in make_sites(0, 6, 120))
        ]

    now = forest()
    monkeypatch.setattr(sites, "_run_on", lambda x, y: (x, y))
    assert now == forest()
    assert any(now)
