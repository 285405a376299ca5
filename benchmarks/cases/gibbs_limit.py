"""Gibbs iterations against the random numbers that they need."""

from __future__ import annotations

import numpy as np
from numba import njit

from avahazard.inference.paper.gibbs import run_gibbs
from benchmarks.measuring import Result, alternate, seconds

N = 1_000_000
N_EVENTS = 173


@njit
def random_numbers(rng, shape, out):  # type: ignore[no-untyped-def]
    """Two normals and a gamma each time, and nothing else."""
    for i in range(len(out)):
        out[i, 0] = rng.standard_normal()
        out[i, 1] = rng.standard_normal()
        out[i, 2] = rng.standard_gamma(shape)


def measure() -> Result:
    """Times per iteration."""
    rng = np.random.default_rng(1)
    # N, mean x, mean y, Σ(x - mean)², smallest Σ residual², slope of least squares
    sums = np.array([N_EVENTS, 0.05, 0.7, 1.4, N_EVENTS * 0.158**2, 0.3])
    mean, precision = np.array([0.7, 0.0]), np.array([4.0, 0.01])
    draws = np.empty((N, 3))

    def ours() -> float:
        return seconds(lambda: run_gibbs(rng, 0.3, 0.02, sums, mean, precision, 1.0, 0.01, draws))

    def theirs() -> float:
        return seconds(lambda: random_numbers(rng, 1.0 + 0.5 * N_EVENTS, draws))

    a, b, ratio = alternate(ours, theirs, 9)
    return Result(
        ratio,
        1e9 * a / N,
        1e9 * b / N,
        "ns per iteration",
        0.63,
        False,
        "time of the random numbers alone over ours",
        "two normals and one gamma an iteration from the same generator.",
    )
