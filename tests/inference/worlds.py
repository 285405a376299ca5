"""Small simulated datasets: tables of stops, and events drawn from a law."""

from __future__ import annotations

import numpy as np

from avahazard.inference.model.laws import law

MU_MIN, MU_STEP = 0.025, 0.0025
MU = MU_MIN + MU_STEP * np.arange(591)


def tables(n_tables: int, rng: np.random.Generator) -> np.ndarray:
    """Stops, m, that rise with friction, with a jump of 40 m in each table."""
    rows = []
    for _ in range(n_tables):
        drop, bend = rng.uniform(900, 1700), rng.uniform(0.6, 1.0)
        reach = np.clip(1.0 - MU / 1.1, 0.0, 1.0) ** bend
        rows.append(2300.0 - drop * reach + 40.0 * (rng.uniform(0.3, 0.6) < MU))
    return np.array(rows)


def runouts(law_name: str, natural, sigma: float, n: int, seed: int):
    """Volumes, recorded stops, table of each event, tables; scatter is in metres."""
    rng = np.random.default_rng(seed)
    stop_y = tables(4, rng)
    volume = np.exp(rng.normal(10.5, 1.4, n))
    table = rng.integers(0, 4, n)
    mu = law(law_name).friction(np.asarray(natural), volume)
    stop = np.array([np.interp(m, MU, stop_y[k]) for m, k in zip(mu, table, strict=True)])
    return volume, stop + rng.normal(0.0, sigma, n), table, stop_y


def frictions(law_name: str, natural, sigma: float, n: int, seed: int):
    """Volumes and apparent frictions with lognormal scatter."""
    rng = np.random.default_rng(seed)
    volume = np.exp(rng.normal(10.5, 1.4, n))
    mu = law(law_name).friction(np.asarray(natural), volume)
    return volume, mu * np.exp(rng.normal(0.0, sigma, n))
