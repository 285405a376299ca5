"""1000 frictions down the longest Tyrol profile: against scipy's solver and a bare loop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd
from numba import njit
from scipy.integrate import solve_ivp

from avahazard.effects.site import SPEED_CELL_M
from avahazard.physics.block import BATCH_SIZE, LEFT_PROFILE, STOPPED
from avahazard.physics.block import run as run_blocks
from avahazard.physics.cells import SPEEDS, build_cells, no_resistance
from avahazard.physics.smooth_profile import (
    SmoothProfile,
    block_length,
    legendre_profile,
    point_error,
    smooth_profile,
    spline_profile,
)
from avahazard.physics.terrain import MAX_CELL_M, build_terrain
from benchmarks.measuring import Row, alternate, processor_seconds, seconds
from benchmarks.study import SHARED

GRAVITY = 9.81
MU = np.linspace(0.2, 0.7, 1000)
"""Frictions of the paper's range, `[1000]`; every block moves off."""
SAMPLE = MU[12::40]
"""The solver is timed on every 40th friction and scaled."""
START = np.array([0])
DRAG, FOREST_DRAG = 0.001, 0.01
FOREST = (0.35, 0.55)
"""Shares of the path between which it stands in forest."""
RATIO, HALF_SPEED = 0.6, 10.0


def longest(regularise: Callable[..., SmoothProfile] = smooth_profile) -> SmoothProfile:
    """The longest profile, regularised."""
    file = SHARED / "tyrol-profiles" / "profiles.csv"
    if not file.exists():
        raise SystemExit(f"The benchmarks need the Tyrol profiles at {file}.")
    table = pd.read_csv(file)
    rows = table[table.path_id == table.groupby("path_id").x_m.max().idxmax()]
    return regularise(rows.x_m.to_numpy(float), rows.y_m.to_numpy(float))


def splined(x: np.ndarray, y: np.ndarray) -> SmoothProfile:
    """The smoothing spline of points, whatever a polynomial misses."""
    return spline_profile(x, y, point_error(x, y), block_length(float(x[-1] - x[0])))


def run() -> Row:
    """Against scipy's solve_ivp on equation 2.3; fails if a stop is off by more than 0.1 m."""
    profile = longest()
    terrain = build_terrain(profile)
    cells, path = build_cells(terrain, no_resistance(terrain)), pieces(profile)
    row, errors = against_solver(
        cells, lambda mu, rtol: solve(motion, path, terrain.x[0], rtol, mu), 0.1
    )
    return (
        *row,
        f"{len(cells.length)} cells, of which blocks leave and meet the ground in many; largest "
        f"error of a stop {1e3 * max(errors):.1f} mm ({len(errors)} stops against rtol 1e-10). The "
        "solver has a compiled right-hand side over the spline's own polynomials, and is timed on "
        f"{len(SAMPLE)} of the frictions, scaled.",
    )


def run_effects(ratio: float = 1.0) -> Row:
    """With drag and forest, and friction that falls to `ratio` with speed; within 10 m."""
    profile, path = longest(), pieces(longest())
    weak = ratio < 1.0
    length = profile.x_max - profile.x_min
    forest = np.array([*(profile.x_min + length * np.array(FOREST)), FOREST_DRAG])
    terrain = build_terrain(profile, forest[:2], SPEED_CELL_M if weak else MAX_CELL_M)
    inside = (terrain.middle_x >= forest[0]) & (terrain.middle_x < forest[1])
    bare_ = no_resistance(terrain)
    resistance = replace(bare_, drag=bare_.drag + DRAG + FOREST_DRAG * inside)
    if weak:
        share = ratio + (1.0 - ratio) / (1.0 + SPEEDS / HALF_SPEED)
        resistance = replace(resistance, speed_factor=share)
    cells, others = build_cells(terrain, resistance), (DRAG, forest, ratio, HALF_SPEED)
    row, errors = against_solver(
        cells, lambda mu, rtol: solve(resisted_motion, path, terrain.x[0], rtol, mu, *others), 10.0
    )
    return (
        *row,
        f"{len(cells.length)} cells, drag {DRAG:g} 1/m and {FOREST_DRAG:g} in forest"
        + (f", friction falling to {ratio:g} of it with speed" if weak else "")
        + f"; stops are off by {np.median(errors):.3f} m at the median, {max(errors):.2f} m at "
        f"most ({len(errors)} stops against rtol 1e-10). The solver as for `run`.",
    )


def run_speed() -> Row:
    """With speed-weakening too."""
    return run_effects(RATIO)


def against_solver(
    cells, stop: Callable[[float, float], float], allowed_m: float
) -> tuple[tuple[float, float, float], list[float]]:
    """Ratio and times (ms) of 1000 runs; errors (m) against rtol 1e-10, where F is continuous."""
    errors = []
    for mu in SAMPLE:
        stops = run_blocks(cells, START, mu + np.array([-1e-6, 0.0, 1e-6]))
        x = stops.x[0]
        if np.all(stops.status == STOPPED) and x[0] - x[2] < 0.1:
            errors.append(abs(x[1] - stop(mu, 1e-10)))
    if not max(errors) <= allowed_m:
        raise SystemExit(f"A stop is off by {max(errors):.3f} m.")

    def theirs() -> float:
        return seconds(lambda: [stop(mu, 1e-8) for mu in SAMPLE]) * len(MU) / len(SAMPLE)

    ratio, a, b = alternate(lambda: seconds(lambda: run_blocks(cells, START, MU), 20), theirs, 5)
    return (ratio, 1e3 * a, 1e3 * b), errors


def pieces(profile: SmoothProfile) -> tuple[np.ndarray, np.ndarray]:
    """Breaks of the profile and its polynomials between them, in powers of t in [-1, 1]."""
    degree = profile.degree or 3
    x = np.unique(np.concatenate([[profile.x_min, profile.x_max], profile.knots]))
    t = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    middle, half = 0.5 * (x[1:] + x[:-1]), 0.5 * np.diff(x)
    y = profile.derivatives(middle[:, None] + half[:, None] * t)[0]
    return x, np.ascontiguousarray(np.linalg.solve(np.vander(t, increasing=True), y.T).T)


@njit
def ground(x, breaks, c):
    """First and second derivative of the profile at x."""
    i = min(max(np.searchsorted(breaks, x, side="right") - 1, 0), len(c) - 1)
    half = 0.5 * (breaks[i + 1] - breaks[i])
    t = (x - breaks[i]) / half - 1.0
    slope, second = 0.0, 0.0
    for k in range(c.shape[1] - 1, 0, -1):
        slope = slope * t + k * c[i, k]
        if k > 1:
            second = second * t + k * (k - 1) * c[i, k]
    return slope / half, second / half**2


@njit
def motion(_time, state, breaks, c, mu):
    """dx/dt and du/dt of equation 2.3."""
    x, u = state
    slope, second = ground(x, breaks, c)
    cos = 1.0 / np.sqrt(1.0 + slope * slope)
    normal = max(0.0, GRAVITY * cos + second * cos**3 * u * u)
    out = np.empty(2)
    out[0] = u * cos
    out[1] = -GRAVITY * slope * cos - mu * normal
    return out


@njit
def resisted_motion(_time, state, breaks, c, mu, drag, forest, ratio, half_speed):
    """The same: `forest` is (from x, to x, drag there), friction falls to `ratio` of it."""
    x, u = state
    slope, second = ground(x, breaks, c)
    cos = 1.0 / np.sqrt(1.0 + slope * slope)
    normal = max(0.0, GRAVITY * cos + second * cos**3 * u * u)
    share = ratio + (1.0 - ratio) / (1.0 + max(u, 0.0) / half_speed)
    brake = drag + (forest[2] if forest[0] <= x < forest[1] else 0.0)
    out = np.empty(2)
    out[0] = u * cos
    out[1] = -GRAVITY * slope * cos - mu * share * normal - brake * u * u
    return out


def at_rest(_time, state, *_):
    return state[1]


def at_end(_time, state, breaks, *_):
    return state[0] - breaks[-1]


at_rest.terminal, at_rest.direction = True, -1.0
at_end.terminal = True


def solve(motion, path, release, rtol, *resisting) -> float:
    """x where the block stops, or the end of the path; `resisting` is what the motion takes."""
    found = solve_ivp(
        motion, (0.0, 1e5), [release, 0.0], method="DOP853", rtol=rtol, atol=1e-9,
        events=[at_rest, at_end], args=(*path, *resisting),
    )  # fmt: skip
    return float(found.y[0, -1])


def run_limit() -> Row:
    """Against a bare loop of the exact form's multiply-adds, where blocks stay on the ground."""
    return (
        *against_loop(legendre_profile, 41),
        "the bare loop steps the same cells in the same blocks of 32 frictions, as far as the last "
        "block of them goes, and looks for no stop. On the polynomial, where the exact form holds "
        "throughout; ours also finds stops, statuses and elevations.",
    )


def run_limit_ground() -> Row:
    """The same on the spline."""
    return (
        *against_loop(splined, 21),
        "as `run_limit`, on the spline through the same points, where blocks leave the ground and "
        "land again: ours then also finds the places of these changes.",
    )


def against_loop(
    regularise: Callable[..., SmoothProfile], rounds: int
) -> tuple[float, float, float]:
    """Our run against the bare loop over the cells that our blocks pass (CPU-ms)."""
    terrain = build_terrain(longest(regularise))
    cells = build_cells(terrain, no_resistance(terrain))
    stops = run_blocks(cells, START, MU)
    last = np.zeros(len(MU), dtype=np.int64)
    stopped, left = stops.status[0] == STOPPED, stops.status[0] == LEFT_PROFILE
    last[stopped] = np.searchsorted(cells.x, stops.x[0][stopped])
    last[left] = len(cells.length)
    n_cells, w = np.maximum.reduceat(last, np.arange(0, len(MU), BATCH_SIZE)), np.empty(len(MU))
    ratio, a, b = alternate(
        lambda: processor_seconds(lambda: run_blocks(cells, START, MU), 50),
        lambda: processor_seconds(lambda: bare(cells.growth, cells.drive, MU, n_cells, w), 50),
        rounds,
    )
    return ratio, 1e3 * a, 1e3 * b


@njit(fastmath={"contract"})
def bare(growth, drive, mu, n_cells, w_end):
    """w ← A(μ) w + B(μ), two polynomials of order 6, over the first cells; nothing else."""
    friction, w = np.empty(BATCH_SIZE), np.empty(BATCH_SIZE)
    for b in range(len(n_cells)):
        for j in range(BATCH_SIZE):
            friction[j] = mu[min(b * BATCH_SIZE + j, len(mu) - 1)]
            w[j] = 0.0
        for i in range(n_cells[b]):
            g0, g1, g2, g3 = growth[i, 0], growth[i, 1], growth[i, 2], growth[i, 3]
            g4, g5, g6 = growth[i, 4], growth[i, 5], growth[i, 6]
            d0, d1, d2, d3 = drive[i, 0], drive[i, 1], drive[i, 2], drive[i, 3]
            d4, d5, d6 = drive[i, 4], drive[i, 5], drive[i, 6]
            for j in range(BATCH_SIZE):
                m = friction[j]
                a = g0 + m * (g1 + m * (g2 + m * (g3 + m * (g4 + m * (g5 + m * g6)))))
                c = d0 + m * (d1 + m * (d2 + m * (d3 + m * (d4 + m * (d5 + m * d6)))))
                w[j] = a * w[j] + c
        for j in range(min(BATCH_SIZE, len(mu) - b * BATCH_SIZE)):
            w_end[b * BATCH_SIZE + j] = w[j]
