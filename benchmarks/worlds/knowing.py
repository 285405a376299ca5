"""One who knows the form of what is hidden: a fit of its own, nothing of avahazard in it.

Log friction is normal about a law that is exponential in the volume; what is hidden has one
amplitude to be found (of a force, a shift or a scatter), a second kind its share and its shift.
Volumes are taken as they were recorded, speeds with independent errors.  The base model is the same
fit without the amplitude.
"""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from benchmarks.worlds import beyond
from benchmarks.worlds.beyond import SCATTER, Floats, Ints, World

MU = np.geomspace(0.1, 1.3, 72)
LOG_MU = np.linspace(np.log(MU[0]), np.log(MU[-1]), 500)
AMPLITUDES = (0.0, 0.5, 1.0, 1.5)
N_DRAWS = 400


@dataclass(slots=True)
class Records:
    """Arrays `[n_events]` (`runout` NaN: beyond the profile), and of speeds `[n_speeds]`."""

    held_out: Ints
    runout: Floats
    sigma: Floats
    volume: Floats
    event: Ints
    place: Floats
    speed: Floats
    speed_sigma: Floats


@dataclass(slots=True)
class Tables:
    """Stops `[n_amplitudes, n_events, n_friction]` and speeds `[n_amplitudes, n_speeds, …]`."""

    amplitudes: tuple[float, ...]
    stop: Floats
    speed: Floats

    def at(self, amplitude: float) -> tuple[Floats, Floats]:
        """Both at an amplitude, linear between those that were run."""
        if len(self.amplitudes) == 1:
            return self.stop[0], self.speed[0]
        last = len(self.amplitudes) - 2
        k = int(np.clip(np.searchsorted(self.amplitudes, amplitude) - 1, 0, last))
        low, high = self.amplitudes[k], self.amplitudes[k + 1]
        t = (float(np.clip(amplitude, 0.0, self.amplitudes[-1])) - low) / (high - low)
        return (
            (1.0 - t) * self.stop[k] + t * self.stop[k + 1],
            (1.0 - t) * self.speed[k] + t * self.speed[k + 1],
        )


def read(folder: Path) -> Records:
    """The records of a dataset, those held-out ones among them."""
    rows: dict[int, tuple[int, dict[str, str]]] = {}
    for held_out, file in enumerate((folder / "events.csv", folder / "held_out" / "events.csv")):
        for row in _rows(file):
            rows[_number(row)] = held_out, row
    ordered = [rows[j] for j in range(len(rows))]
    speeds = _rows(folder / "velocities.csv")

    def numbers(of: list[dict[str, str]], name: str) -> Floats:
        return np.array([float(row[name] or "nan") for row in of])

    events = [row for _, row in ordered]
    return Records(
        held_out=np.array([h for h, _ in ordered]),
        runout=numbers(events, "runout_x_m"),
        sigma=numbers(events, "runout_sigma_m"),
        volume=numbers(events, "volume_m3"),
        event=np.array([_number(row) for row in speeds], np.int64),
        place=numbers(speeds, "x_m"),
        speed=numbers(speeds, "speed_m_s"),
        speed_sigma=numbers(speeds, "speed_sigma_m_s"),
    )


def _rows(file: Path) -> list[dict[str, str]]:
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def _number(row: dict[str, str]) -> int:
    return int(row["event_id"].rpartition("-")[2])


def tabulate(world: World, records: Records) -> Tables:
    """Run every event at all frictions, by the integrator of the datasets."""
    force = world.force
    amplitudes = AMPLITUDES if force is not None else (0.0,)
    n, m = len(world.path), len(MU)
    stop = np.empty((len(amplitudes), n, len(LOG_MU)))
    speed = np.empty((len(amplitudes), len(records.event), len(LOG_MU)))
    for a, amplitude in enumerate(amplitudes):

        def scaled(state: beyond.State, by: float = amplitude) -> Floats:
            assert force is not None
            return by * force(state)

        for k, terrain in enumerate(world.terrains):
            selected = np.flatnonzero(world.path == k)
            x, w = beyond.run(
                terrain, np.repeat(world.release[selected], m), np.tile(MU, len(selected)),
                scaled if amplitude else None, k, float(world.lengths_m[k]),
            )  # fmt: skip
            start = np.repeat(terrain.x[world.release[selected]], m)
            x = np.where(np.isnan(x), start, np.minimum(x, terrain.x[-1] + 1e3))
            for i, j in enumerate(selected):
                part = slice(i * m, (i + 1) * m)
                stop[a, j] = np.interp(LOG_MU, np.log(MU), x[part])
                for q in np.flatnonzero(records.event == j):
                    at = records.place[q] / beyond.STEP_M
                    low, t = int(at), at - int(at)
                    squares = (1.0 - t) * w[low, part] + t * w[low + 1, part]
                    speed[a, q] = np.interp(LOG_MU, np.log(MU), np.sqrt(squares))
    return Tables(amplitudes, stop, speed)


def knowing(folder: Path) -> dict[str, float]:
    """Gain (nats) of who knows the form, and held-out CRPS (m) of both models.

    Of a dataset in which nothing is hidden the two are the same.
    """
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    world, _, shift = beyond.drawn(truth["arm"], truth["seed"])
    records = read(folder)
    tables = tabulate(world, records)
    kinds = truth["right"] == ["two-kinds"]
    relative = np.log(world.scatter / SCATTER)
    shift = np.zeros_like(shift) if kinds else shift - shift.mean()
    relative -= relative.mean()
    hidden = kinds or world.force is not None or np.ptp(shift) + np.ptp(relative) > 1e-9
    first = np.array([np.log(0.45), 0.5, np.log(0.12)])

    def fit(n_more: int, start: Floats) -> tuple[float, Floats]:
        best = minimize(
            lambda v: -log_likelihood(v, n_more), start, method="Nelder-Mead",
            options={"xatol": 1e-3, "fatol": 1e-2, "maxiter": 1500, "maxfev": 1500},
        )  # fmt: skip
        return -float(best.fun), best.x

    def parts(v: Floats, n_more: int) -> tuple[float, Floats, Floats, float, float]:
        """Amplitude, median and sd of log friction, share and shift of a second kind."""
        median, sd = v[0] - 1e-6 * v[1] * records.volume, np.full(len(shift), v[2])
        if not n_more:
            return 0.0, median, np.exp(sd), 0.0, 0.0
        if kinds:
            return 0.0, median, np.exp(sd), 1.0 / (1.0 + np.exp(-v[3])), v[4]
        amplitude = v[3] if world.force is not None else 0.0
        if world.force is None:
            median, sd = median + v[3] * shift, sd + v[3] * relative
        return amplitude, median, np.exp(sd), 0.0, 0.0

    train = records.held_out == 0
    seen = train & np.isfinite(records.runout)

    def log_likelihood(v: Floats, n_more: int) -> float:
        amplitude, median, sd, share, second = parts(v, n_more)
        stop, speed = tables.at(amplitude)
        z = (records.runout[:, None] - stop) / records.sigma[:, None]
        fits = np.where(seen[:, None], -0.5 * z * z, 0.0)
        if len(records.event):
            off = (records.speed[:, None] - speed) / records.speed_sigma[:, None]
            np.add.at(fits, records.event, -0.5 * off * off)
        highest = fits.max(axis=1)
        weight = (1.0 - share) * _normal(median, sd) + share * _normal(median + second, sd)
        inside = np.sum(np.exp(fits - highest[:, None]) * weight, axis=1)
        return float(np.sum((highest + np.log(np.maximum(inside, 1e-300)))[train]))

    base, at_base = fit(0, first)
    more = [np.log(0.4 / 0.6), -0.25] if kinds else [0.5]
    n_more = len(more) if hidden else 0
    best, at_best = fit(n_more, np.append(at_base, more)) if n_more else (base, at_base)
    return {
        "gain": round(best - base, 2),
        "base_crps": round(_crps(records, tables, parts(at_base, 0)), 2),
        "crps": round(_crps(records, tables, parts(at_best, n_more)), 2),
    }


def _normal(median: Floats, sd: Floats) -> Floats:
    """Weights `[n_events, n_friction]` of the frictions."""
    z = (LOG_MU - median[:, None]) / sd[:, None]
    return np.exp(-0.5 * z * z) * ((LOG_MU[1] - LOG_MU[0]) / np.sqrt(2.0 * np.pi) / sd[:, None])


def _crps(
    records: Records, tables: Tables, model: tuple[float, Floats, Floats, float, float]
) -> float:
    """Mean fair CRPS (m) of the held-out runouts."""
    amplitude, median, sd, share, second = model
    stop, _ = tables.at(amplitude)
    rng = np.random.default_rng(1)
    scores = []
    for j in np.flatnonzero((records.held_out == 1) & np.isfinite(records.runout)):
        log_mu = median[j] + sd[j] * rng.normal(size=N_DRAWS)
        log_mu += second * (rng.uniform(size=N_DRAWS) < share)
        x = np.interp(log_mu, LOG_MU, stop[j]) + records.sigma[j] * rng.normal(size=N_DRAWS)
        scores.append(fair_crps(x, records.runout[j]))
    return float(np.mean(scores))


def fair_crps(draws: Floats, observed: float) -> float:
    """Mean distance of draws `[n]` to what was observed, less half of that between two draws."""
    n = len(draws)
    between = np.sum((2.0 * np.arange(n) - n + 1.0) * np.sort(draws)) / (n * (n - 1.0))
    return float(np.mean(np.abs(draws - observed)) - between)
