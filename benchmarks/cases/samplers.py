"""The paper's samplers and draws of runouts, against emcee and the random numbers alone."""

from __future__ import annotations

import time
from typing import NamedTuple

import emcee
import numpy as np
import pandas as pd
from numba import njit
from numpy.typing import NDArray

from avahazard.hazard.rows import draw_stops
from avahazard.inference.fitted_model import diagnose_chains
from avahazard.inference.model.laws import law
from avahazard.inference.paper.calibration import (
    FLAT_ON_SIGMA,
    Prior,
    prior_by,
    run_gibbs,
    runout_records,
    squared_residuals,
    walk,
)
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.runout_curve import EVEN, MU, MU_STEP, pieces, tabulate
from avahazard.physics.smooth_profile import legendre_profile, smooth_profile
from avahazard.physics.terrain import build_terrain
from benchmarks.cases.blocks import longest
from benchmarks.measuring import Row, alternate, seconds
from benchmarks.study import ROOT

Floats = NDArray[np.float64]
N_WALKERS, N_STEPS, N_BURN = 32, 3000, 500
N_DRAWS = 25_000
N_EVENTS = 173
N_GIBBS, N_RUNOUTS = 1_000_000, 10_000_000
MEAN, SD = 0.5, 0.08


class Twin(NamedTuple):
    """The twin's events `[n_events]` and F(μ) `[n_paths, n_mu]`; `mu` is only to start from."""

    volume: Floats
    runout: Floats
    table: NDArray[np.int64]
    stop_y: Floats
    mu_min: float
    mu_step: float
    mu: Floats


def twin() -> Twin:
    """Read the twin; blocks start from their path's release, those beyond it at its end."""
    paths, profiles, events = (
        pd.read_csv(ROOT / "data" / f"{name}.csv") for name in ("paths", "profiles", "events")
    )
    stop_y, ends = np.empty((len(paths), len(MU[EVEN]))), np.empty(len(paths))
    for k, path in enumerate(paths.itertuples()):
        rows = profiles[profiles.path_id == path.path_id]
        smooth = smooth_profile(rows.x_m.to_numpy(float), rows.y_m.to_numpy(float))
        fine = np.linspace(smooth.x_min, smooth.x_max, 20_000)
        release = fine[np.argmax(smooth.height(fine) <= path.release_elevation_m)]
        terrain = build_terrain(smooth, np.array([release]))
        start = np.array([terrain.node(release)])
        table = tabulate(build_cells(terrain, no_resistance(terrain)), start)
        ends[k] = terrain.y[-1]
        stop_y[k] = np.where(table.left[0], ends[k], table.y[0])[EVEN]
    which = events.path_id.map({name: k for k, name in enumerate(paths.path_id)}).to_numpy(np.int64)
    runout = events.runout_elevation_m.fillna(pd.Series(ends[which])).to_numpy(float)
    near = [np.argmin(np.abs(stop_y[k] - y)) for k, y in zip(which, runout, strict=True)]
    volume, mu = events.volume_m3.to_numpy(float), MU[EVEN]
    return Twin(volume, runout, which, stop_y, float(mu[0]), MU_STEP, mu[near])


@njit
def log_density(points, records, mean, precision, place):
    """Our posterior at points `[n_walkers, 3]`: coordinates of the law and log σ, flat on σ."""
    out = np.empty(len(points))
    for i in range(len(points)):
        u, log_sigma = points[i, :2], points[i, 2]
        squares = squared_residuals(u, records, place)
        out[i] = -0.5 * np.sum((u - mean) ** 2 * precision) - 0.5 * squares * np.exp(-2 * log_sigma)
        out[i] += (1 - len(records.y)) * log_sigma
    return out


def mh_emcee() -> Row:
    """Smallest effective sample size per second, on the twin's 173 events."""
    exponential, data = law("exponential"), twin()
    records = runout_records(exponential, *data[:6])
    mean, sd = exponential.prior_mean, exponential.prior_sd
    start = exponential.start(data.volume, data.mu)
    seeds, place = iter(range(1, 1000)), np.empty(len(records.y))
    moments = {}

    def ours() -> float:
        begin = time.perf_counter()
        prior = prior_by(mean, sd, FLAT_ON_SIGMA)
        draws, sigma, _ = walk(
            records, prior, start, np.diag([0.03, 0.15]), next(seeds), 4, N_DRAWS
        )
        taken = time.perf_counter() - begin
        both = np.concatenate([draws, np.log(sigma)[..., None]], axis=2)
        moments["ours"] = both.mean(axis=(0, 1)), both.std(axis=(0, 1))
        return diagnose_chains(both).ess_bulk_min / taken

    def theirs() -> float:
        rng = np.random.default_rng(next(seeds))
        first = np.append(start, np.log(150.0)) + rng.normal(size=(N_WALKERS, 3)) * 0.05
        sampler = emcee.EnsembleSampler(
            *(N_WALKERS, 3, lambda p: log_density(p, records, mean, sd**-2.0, place)),
            vectorize=True,
        )
        state = sampler.run_mcmc(first, N_BURN)
        sampler.reset()
        begin = time.perf_counter()
        sampler.run_mcmc(state, N_STEPS)
        taken = time.perf_counter() - begin
        chain = np.swapaxes(sampler.get_chain(), 0, 1)
        moments["theirs"] = chain.mean(axis=(0, 1)), chain.std(axis=(0, 1))
        by_time = N_WALKERS * N_STEPS / np.max(sampler.get_autocorr_time(quiet=True))
        return max(diagnose_chains(chain).ess_bulk_min, by_time) / taken

    inverse, a, b = alternate(ours, theirs, 7)
    off = np.max(np.abs(moments["ours"][0] - moments["theirs"][0]) / moments["theirs"][1])
    if off > 0.15:
        raise SystemExit(f"mh_emcee: the two posteriors differ by {off:.2f} sd.")
    note = (
        f"means of the two posteriors agree within {off:.2f} sd. Our time includes four chains "
        "with their warm-up; emcee's burn-in is not counted. emcee calls our compiled log "
        "density once for all walkers of a half step, and is given the better of two estimates "
        "of its ESS."
    )
    return 1.0 / inverse, a, b, note


@njit
def random_numbers(rng, shape, out):
    """Two normals and a gamma each time, and nothing else."""
    for i in range(len(out)):
        out[i, 0] = rng.standard_normal()
        out[i, 1] = rng.standard_normal()
        out[i, 2] = rng.standard_gamma(shape)


def gibbs_limit() -> Row:
    """Gibbs iterations against the random numbers that they need."""
    rng = np.random.default_rng(1)
    # N, mean x, mean y, Σ(x - mean)², smallest Σ residual², slope of least squares
    sums = np.array([N_EVENTS, 0.05, 0.7, 1.4, N_EVENTS * 0.158**2, 0.3])
    prior = Prior(np.array([0.7, 0.0]), np.array([4.0, 0.01]), 1.0, 0.01)
    draws, shape = np.empty((N_GIBBS, 3)), 1.0 + 0.5 * N_EVENTS
    ratio, a, b = alternate(
        lambda: seconds(lambda: run_gibbs(rng, 0.3, 0.02, sums, prior, draws)),
        lambda: seconds(lambda: random_numbers(rng, shape, draws)),
        9,
    )
    note = "two normals and one gamma an iteration from the same generator."
    return ratio, 1e9 * a / N_GIBBS, 1e9 * b / N_GIBBS, note


def draws_limit() -> Row:
    """Runouts from P[μ|V] against numpy's normal draws and numpy.interp."""
    terrain = build_terrain(longest(legendre_profile))
    curve = tabulate(build_cells(terrain, no_resistance(terrain)), np.array([0]))[0]
    filled, rng = np.where(curve.left, terrain.x[-1], curve.x), np.random.default_rng(1)
    curves, of = pieces(curve[None]), np.zeros(N_RUNOUTS, np.int64)

    def rounds(in_log, sd, transform):
        location = np.full(N_RUNOUTS, np.log(MEAN) if in_log else MEAN)
        given = of, location, np.full(N_RUNOUTS, sd), in_log
        return alternate(
            lambda: seconds(lambda: draw_stops(rng, *curves, *given)),
            lambda: seconds(
                lambda: np.interp(transform(rng.standard_normal(N_RUNOUTS)), MU, filled)
            ),
            5,
        )

    normal = rounds(False, SD, lambda z: MEAN + SD * z)
    lognormal = rounds(True, SD / MEAN, lambda z: MEAN * np.exp(SD / MEAN * z))
    return (
        *normal,
        "normal friction. Ours gives x and elevation of every stop, counts statuses, never "
        "interpolates across a jump of F, and draws by a location and scatter for each; theirs "
        f"gives x alone. With lognormal friction on both sides the ratio is {lognormal[0]:.2f}.",
    )
