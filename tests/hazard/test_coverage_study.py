"""The observations of coverage: its truth, and a small part of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.hazard.frequency import known_volumes, volume_frequencies
from avahazard.synth.dataset import make_track, run_track
from avahazard.synth.making import LAST_YEAR
from benchmarks.coverage import covered, judge, kept, planned, share, tables
from benchmarks.study import DOCS, with_parts
from benchmarks.true_worlds import (
    ARMS,
    LEFT,
    SPARSE_FROM,
    TAU,
    UNSEEN,
    TrueWorld,
    exceeded_once,
    run_path,
    sparse_world,
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


def test_harder_worlds_are_what_they_are_called() -> None:
    differ, limited, cut = (ARMS[a](5) for a in ("paths differ", "limit of sight", "a third left"))
    assert differ.effects == ("path-effect",)
    offsets = np.concatenate([ARMS["paths differ"](seed).offsets for seed in range(5, 13)])
    assert offsets.std() == pytest.approx(TAU, rel=0.35)
    assert all(path.observed_below_m is not None for path in limited.records.paths)
    plain = ARMS["plain"](5)
    fewer = len(limited.records.events) / len(plain.records.events)
    assert fewer == pytest.approx(1.0 - UNSEEN, abs=0.12)
    assert np.array_equal(limited.rates, plain.rates)
    assert cut.told is not None
    left = np.mean([event.left_profile for event in cut.told.events])
    assert left == pytest.approx(LEFT, abs=0.03)
    ends = {p.path_id: p.y_m[-1] for p in cut.told.profiles}
    for event in cut.told.events:
        if event.runout_elevation_m is not None:
            assert event.runout_elevation_m >= ends[event.path_id or ""]
    assert cut.records is not cut.told


def test_an_offset_moves_the_truth(world: TrueWorld) -> None:
    runs = run_path(world, 0)
    volume = np.full(2000, 5e4)
    slippery = replace(world, offsets=np.full(5, -0.1))
    plain, moved = (true_runouts(w, 0, runs, volume) for w in (world, slippery))
    assert np.median(moved) > np.median(plain) + 10.0


def test_the_plan_has_every_arm_and_no_world_twice() -> None:
    worlds = planned(3, 2, 4)
    assert len(worlds) == len(set(worlds)) == 3 + 2 * (len(ARMS) - 2) + 4


def test_sparse_paths_have_the_winters_of_the_data_set() -> None:
    sparse = sparse_world(2)
    assert all(p.observed_from is p.observed_to is None for p in sparse.records.paths)
    found = volume_frequencies(known_volumes(sparse.records), 1).region.records
    windows = {(record.first_year, record.last_year) for record in found.values()}
    ((first, last),) = windows
    assert SPARSE_FROM < first <= SPARSE_FROM + 6
    assert LAST_YEAR - 6 <= last <= LAST_YEAR
    ratios = [found[s.path.path_id].events_per_year for s in sparse.sites] / sparse.rates
    assert np.median(ratios) == pytest.approx(1.0, abs=0.4)


@pytest.mark.slow
def test_most_intervals_of_sparse_paths_hold_the_truth() -> None:
    """Of the 200 datasets of the study four: 48 paths, of which 44 are expected."""
    worlds = kept([judge(sparse_world(seed), ["gev"]) for seed in range(301, 305)])
    mean, _ = share(worlds, lambda p: covered(p, "gev", "b"))
    assert 0.8 <= mean <= 1.0


@pytest.mark.slow
def test_most_intervals_of_a_few_worlds_hold_the_truth() -> None:
    """The whole study is `make coverage`; here are 60 paths, of which 54 are expected."""
    lines = [{"arm": "plain", **judge(true_world(seed))} for seed in range(301, 313)]
    worlds = kept(lines)
    for family in ("gev", "gpd"):
        mean, _ = share(worlds, lambda p, f=family: covered(p, f, "b"))
        assert 0.8 <= mean <= 1.0
    written = (DOCS / "coverage.md").read_text(encoding="utf-8")
    assert "12 datasets" in with_parts(written, tables(lines))
