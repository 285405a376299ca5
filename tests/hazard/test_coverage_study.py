"""The observations of coverage: its truth, and a small part of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.synth.integrator import run_track
from avahazard.synth.track import make_track
from benchmarks.coverage_study.judging import judge
from benchmarks.coverage_study.page import covered, kept, page, share
from benchmarks.coverage_study.world import (
    TrueWorld,
    exceeded_once,
    run_path,
    true_runouts,
    true_volumes,
    true_world,
)


@pytest.fixture(scope="module")
def world() -> TrueWorld:
    return true_world(3)


def test_the_truth_without_scatter_is_a_run_of_the_integrator(world: TrueWorld) -> None:
    settings = replace(world.settings, scatter=1e-9)
    runs = run_path(world, 0)
    found = true_runouts(replace(world, settings=settings), 0, runs, np.full(4000, 1e5))
    site = world.sites[0]
    track = make_track(site.profile.x_m, site.profile.y_m)
    x, y = track.fine(2.0)
    zone = (y >= y.max() - 0.25 * np.ptp(y)) & (y <= y.max() - 0.02 * np.ptp(y))
    steep = x[zone & (track.slope(x) >= 0.8)]
    mu = np.exp(settings.law.log_friction(np.full(len(steep), 1e5)))
    _, stop, _ = run_track(track, steep, mu, 2.0)
    assert np.mean(found) == pytest.approx(np.mean(stop), abs=5.0)
    assert (found.min(), found.max()) == pytest.approx((stop.min(), stop.max()), abs=25.0)


def test_true_volumes_are_those_of_the_records(world: TrueWorld) -> None:
    recorded = [e.volume_m3 for e in world.records.events if e.path_id == "P1"]
    middle = float(true_volumes(world, 0, np.array([0.5]))[0])
    assert np.median(recorded) == pytest.approx(middle, rel=0.5)
    assert true_volumes(world, 0, np.array([0.0, 1.0])) == pytest.approx([2e3, 8e5])


def test_exceeded_once_is_exceeded_at_the_rate(world: TrueWorld) -> None:
    runouts = np.arange(100_000) / 1e5
    found = exceeded_once(world, 0, runouts, 100.0)
    assert world.rates[0] * np.mean(runouts > found) == pytest.approx(0.01005, abs=1e-4)


@pytest.mark.slow
def test_most_intervals_of_a_few_worlds_hold_the_truth() -> None:
    """The whole study is `make coverage`; here are 60 paths, of which 54 are expected."""
    lines = [judge(true_world(seed)) for seed in range(301, 313)]
    worlds = kept(lines)
    for family in ("gev", "gpd"):
        mean, _ = share(worlds, lambda p, f=family: covered(p, f, "b"))
        assert 0.8 <= mean <= 1.0
    assert "# Coverage" in page(lines, "a test")
