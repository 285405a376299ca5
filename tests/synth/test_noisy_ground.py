"""Errors of a profile's points do not pass for physics: ground and blocks are those of synth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.physics.block import LEFT_PROFILE, STOPPED, run
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.physics.terrain import build_terrain
from avahazard.records.collection import Profile, Records
from avahazard.records.reading import read_records
from avahazard.synth.dataset import Settings, SitePlan, make_track, run_track
from avahazard.synth.making import RUN_ON_M, concave_profile, make_dataset, make_sites
from avahazard.synth.writing import write_records

MU = np.exp(np.random.default_rng(0).normal(np.log(0.47), 0.15, 40))
CASES = list(product((1.0, 2.0, 3.0, 5.0), (10.0, 25.0, 50.0)))


@dataclass(frozen=True, slots=True)
class NoisyPlan:
    """A dataset: its ground, and how far apart (m) and how wrong (m, one sd) its points are."""

    seed: int
    benched: bool = False
    spacing_m: float = 10.0
    sigma_m: float = 5.0
    n_events: int = 240
    n_paths: int = 9


def noisy_world(plan: NoisyPlan) -> Records:
    """The records, with the points of the ground as they were measured."""
    sites = make_sites(plan.seed, plan.n_paths, plan.n_events)
    if plan.benched:
        sites = tuple(_with_benches(site, plan.seed + k) for k, site in enumerate(sites))
    exact, _ = make_dataset(plan.seed, settings=Settings(), sites=sites)
    rng = np.random.default_rng([plan.seed, 8])
    profiles = [measured(p, plan.spacing_m, plan.sigma_m, False, rng) for p in exact.profiles]
    return replace(exact, profiles=tuple(profiles))


def measured(
    true: Profile, spacing_m: float, sigma_m: float, told: bool, rng: np.random.Generator
) -> Profile:
    """Points of the true ground, so far apart, each elevation with an error of its own."""
    track = make_track(true.x_m, true.y_m)
    x = np.append(np.arange(true.x_m[0], true.x_m[-1] - 0.5 * spacing_m, spacing_m), true.x_m[-1])
    y = track.elevation(x) + rng.normal(0.0, sigma_m, len(x))
    at = np.clip(np.searchsorted(true.x_m, x, "right") - 1, 0, len(true.x_m) - 1)
    cover = None if true.land_cover is None else tuple(true.land_cover[i] for i in at)
    sigma = np.full(len(x), sigma_m) if told else None
    return Profile(true.path_id, x, np.round(y, 3), cover, elevation_sigma_m=sigma)


def _with_benches(site: SitePlan, seed: int) -> SitePlan:
    """The same site with benches 120 to 300 m long in the middle of its path."""
    rng = np.random.default_rng([seed, 9])
    true = site.profile
    drop = site.drop_m or float(np.ptp(true.y_m))
    length = float(true.x_m[-1]) - RUN_ON_M
    bench = (float(rng.uniform(0.2, 0.4)), length / rng.uniform(120.0, 300.0), rng.uniform())
    power = float(rng.uniform(1.3, 1.9))
    x, y = concave_profile(drop, float(true.y_m[0]), (1.0, 0.08), power, (bench,), (400.0, 0.06))
    return replace(site, profile=Profile(true.path_id, x, y))


def smooth_ground() -> list[Profile]:
    return [site.profile for site in make_sites(21, 3, 30)]


def benched_ground() -> list[Profile]:
    benches = ((0.3, 12.0, 0.2), (0.35, 8.0, 0.6), (0.3, 10.0, 0.9))
    grounds = [concave_profile(1200.0, 2400.0, (1.0, 0.08), 1.5, (wave,), (400.0, 0.06))
               for wave in benches]  # fmt: skip
    return [Profile(f"B{k}", x, y) for k, (x, y) in enumerate(grounds)]


def misses(true: Profile, points: Profile) -> tuple[np.ndarray, np.ndarray, int]:
    """How far stops on the points lie off the true ones, m in x and elevation, and how many left.

    Of blocks that stop on both; those that run beyond the path on the points only are counted.
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
        records = noisy_world(NoisyPlan(seed, benched, n_events=60, n_paths=3))
        folder = tmp_path / str(seed)
        folder.mkdir()
        write_records(folder, records)
        assert len(read_records([folder]).events) == 60


@pytest.mark.parametrize("benched", [False, True])
def test_the_friction_comes_back(benched: bool) -> None:
    records = noisy_world(NoisyPlan(4, benched, 10.0, 5.0, n_events=120, n_paths=5))
    posterior = Posterior(build_observations(records), Specification(), ())
    mode = find_mode(posterior)
    k = next(k for k, slot in enumerate(posterior.layout.slots) if slot.name == "log a")
    assert abs(mode.u[k] - np.log(0.5)) < 2.6 * np.sqrt(mode.covariance[k, k])


@pytest.mark.slow
@pytest.mark.parametrize("benched", [False, True])
@pytest.mark.parametrize(("sigma", "spacing"), [(5.0, 10.0), (3.0, 25.0), (5.0, 50.0)])
def test_noise_is_given_no_name(sigma: float, spacing: float, benched: bool) -> None:
    records = noisy_world(NoisyPlan(4, benched, spacing, sigma))
    found = diagnose(build_observations(records), Specification(), {})
    assert (found.result.verdict, found.result.missing) == ("adequate", ())
