"""Scores of predictive draws against records."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.expected import ExpectedRecords
from avahazard.results.comparison import RunoutScores, SpeedScores

CRPS_OF_NORMAL = 1.0 / np.sqrt(np.pi)
"""Expected CRPS of a normal forecast that is right, per standard deviation."""
PIT_BINS = 10


def runout_scores(expected: ExpectedRecords, pit: Floats, floor: Floats) -> RunoutScores:
    """Scores of runouts, in metres of each record.

    `bias_m` is predicted mean less record; where elevations are mixed with others, it counts as
    elevations do (> 0: recorded farther down than predicted). The noise floor is what errors of
    the records alone leave: root mean square of their standard deviations `floor`
    `[n_events]`, and as CRPS. Besides: the histogram of the PIT `[n_events]` in ten equal bins.
    """
    return RunoutScores(
        n=len(expected.observed),
        rmse_m=_root_mean_square(expected.error),
        bias_m=float(np.mean(expected.error)),
        crps_m=float(np.mean(crps(expected.draws, expected.observed))),
        coverage_50=_coverage(pit, 0.5),
        coverage_90=_coverage(pit, 0.9),
        noise_floor_m=_root_mean_square(floor),
        noise_floor_crps_m=float(CRPS_OF_NORMAL * np.mean(floor)),
        pit_histogram=tuple(np.histogram(pit, PIT_BINS, (0.0, 1.0))[0].tolist()),
    )


def speed_scores(draws: Floats, observed: Floats, sigma: Floats, pit: Floats) -> SpeedScores:
    """Scores of speeds, m/s; all arrays over measured places."""
    error = draws.mean(axis=1) - observed
    return SpeedScores(
        n=len(observed),
        rmse_m_s=_root_mean_square(error),
        bias_m_s=float(np.mean(error)),
        crps_m_s=float(np.mean(crps(draws, observed))),
        coverage_50=_coverage(pit, 0.5),
        coverage_90=_coverage(pit, 0.9),
        noise_floor_m_s=_root_mean_square(sigma),
    )


def crps(draws: Floats, observed: Floats) -> Floats:
    """Continuous ranked probability score of each event `[n_events]` by draws `[n_events, n]`.

    The fair estimator, mean |X - y| - ½ mean |X - X'| (Ferro 2014), the latter mean from the
    sorted draws.
    """
    n = draws.shape[1]
    rank = 2.0 * np.arange(1, n + 1) - n - 1.0
    spread = np.sort(draws, axis=1) @ rank * 2.0 / (n * (n - 1.0))
    return np.asarray(np.mean(np.abs(draws - observed[:, None]), axis=1) - 0.5 * spread)


def record_pit(expected: ExpectedRecords, rng: np.random.Generator) -> Floats:
    """`randomised_pit` of the records `[n_events]`, in the direction of their `sign`."""
    pit = randomised_pit(expected.draws, expected.observed, rng)
    return np.where(expected.sign < 0.0, 1.0 - pit, pit)


def randomised_pit(draws: Floats, observed: Floats, rng: np.random.Generator) -> Floats:
    """Rank of each record among its draws, in (0, 1); ties and the last place are drawn at random.

    Uniform where the predictive distribution is right, also for records at a profile's end
    (Czado, Gneiting and Held 2009). Returns `[n_events]`.
    """
    below = np.sum(draws < observed[:, None], axis=1)
    equal = np.sum(draws == observed[:, None], axis=1)
    return np.asarray((below + rng.random(len(observed)) * (equal + 1)) / (draws.shape[1] + 1))


def _root_mean_square(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _coverage(pit: Floats, share: float) -> float:
    """Share of the records in the middle interval that should hold `share` of them."""
    return float(np.mean(np.abs(pit - 0.5) <= 0.5 * share))
