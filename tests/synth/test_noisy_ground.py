"""Errors of a profile's points do not pass for physics: ground and blocks are those of synth."""

from __future__ import annotations

from itertools import product
from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.physics.block import LEFT_PROFILE, STOPPED, run
from avahazard.physics.cells import build_cells
from avahazard.physics.resistance import no_resistance
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.physics.terrain import build_terrain
from avahazard.records.path import Profile
from avahazard.records.reading import read_records
from avahazard.synth.integrator import make_track, run_track
from avahazard.synth.making import concave_profile, make_sites
from avahazard.synth.writing import write_records
from benchmarks.noisy_ground import NoisyPlan, measured, noisy_world
from benchmarks.profile_noise import friction

MU = np.exp(np.random.default_rng(0).normal(np.log(0.47), 0.15, 40))
CASES = list(product((1.0, 2.0, 3.0, 5.0), (10.0, 25.0, 50.0)))


def smooth_ground() -> list[Profile]:
    return [site.profile for site in make_sites(21, 3, 30)]


def benched_ground() -> list[Profile]:
    benches = ((0.3, 12.0, 0.2), (0.35, 8.0, 0.6), (0.3, 10.0, 0.9))
    grounds = [concave_profile(1200.0, 2400.0, (1.0, 0.08), 1.5, (wave,), (400.0, 0.06))
               for wave in benches]  # fmt: skip
    return [Profile(f"B{k}", x, y) for k, (x, y) in enumerate(grounds)]


def misses(true: Profile, points: Profile) -> tuple[np.ndarray, np.ndarray, int]:
    """How far stops on the points lie off the true ones, m in x and elevation, and how many left.

    Of those blocks that leave the path on neither; counted are those that leave on the points only.
    """
    track = make_track(true.x_m, true.y_m)
    release = float(track.place(true.y_m[0] - 0.1 * np.ptp(true.y_m)))
    status, stop, _ = run_track(track, np.full(len(MU), release), MU)
    smooth = smooth_profile(points.x_m, points.y_m, points.elevation_sigma_m)
    terrain = build_terrain(smooth, np.array([release]))
    found = run(build_cells(terrain, no_resistance(terrain)), np.array([terrain.node(release)]), MU)
    both = (status == STOPPED) & (found.status[0] == STOPPED)
    x = found.x[0, both]
    off = track.elevation(x) - track.elevation(stop[both])
    left = int(np.sum((found.status[0] == LEFT_PROFILE) & (status == STOPPED)))
    return x - stop[both], off, left


def test_stops_on_exact_points_are_those_of_the_ground() -> None:
    for true in smooth_ground():
        x, _, left = misses(true, true)
        assert np.abs(x).max() < 3.0
        assert left == 0


@pytest.mark.parametrize(("sigma", "spacing"), CASES)
@pytest.mark.parametrize("told", [False, True])
def test_stops_on_noisy_points_of_smooth_ground(sigma: float, spacing: float, told: bool) -> None:
    rng = np.random.default_rng(5)
    off, left = [], 0
    for true in smooth_ground():
        _, y, gone = misses(true, measured(true, spacing, sigma, told, rng))
        off.append(y)
        left += gone
    assert np.sqrt(np.mean(np.concatenate(off) ** 2)) < sigma * np.sqrt(spacing / 25.0) + 1.0
    assert left == 0


@pytest.mark.parametrize(("sigma", "spacing"), CASES)
def test_stops_on_noisy_points_of_benches(sigma: float, spacing: float) -> None:
    """F jumps there, so single blocks may stop a bench higher; most may not."""
    rng = np.random.default_rng(6)
    off, left = [], 0
    for true in benched_ground():
        _, y, gone = misses(true, measured(true, spacing, sigma, True, rng))
        off.append(np.abs(y))
        left += gone
    assert np.median(np.concatenate(off)) < 3.0 * sigma
    assert left <= 0.03 * len(MU) * len(benched_ground())


@pytest.mark.parametrize("benched", [False, True])
def test_noise_refuses_no_import(tmp_path: FilePath, benched: bool) -> None:
    for seed in (1, 2, 3):
        records, _ = noisy_world(NoisyPlan(seed, benched, n_events=60, n_paths=3))
        folder = tmp_path / str(seed)
        folder.mkdir()
        write_records(folder, records)
        assert len(read_records([folder]).events) == 60


@pytest.mark.parametrize("benched", [False, True])
def test_the_friction_comes_back(benched: bool) -> None:
    records, _ = noisy_world(NoisyPlan(4, benched, 10.0, 5.0, n_events=120, n_paths=5))
    observations = build_observations(records)
    assert abs(friction(observations)["off_sd"]) < 2.6


@pytest.mark.slow
@pytest.mark.parametrize("benched", [False, True])
@pytest.mark.parametrize(("sigma", "spacing"), [(5.0, 10.0), (3.0, 25.0), (5.0, 50.0)])
def test_noise_is_given_no_name(sigma: float, spacing: float, benched: bool) -> None:
    records, _ = noisy_world(NoisyPlan(4, benched, spacing, sigma))
    found = diagnose(build_observations(records), Specification(), {})
    assert (found.verdict, found.missing) == ("adequate", ())
