"""Scores of predictive draws against records, in the coordinate of these or along the path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.criticism.scoring.expected import ExpectedRecords
from avahazard.inference.model.observations import LEFT, LENGTH, PLACE, Observations
from avahazard.inference.seeds import generator
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.results.comparison import RunoutScores, SpeedScores

CRPS_OF_NORMAL = 1.0 / np.sqrt(np.pi)
"""Expected CRPS of a normal forecast that is right, per standard deviation."""
PIT_BINS = 10
N_PLACES = 4001


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


def in_x(expected: ExpectedRecords, observations: Observations) -> ExpectedRecords | None:
    """The same in x (m) for the events with a profile; None where there is none.

    An elevation, recorded or drawn with the record's error, is put where the path first falls to
    it, as `stop_place` does; `sigma` is half of what ±sigma of elevation is along the path.
    """
    events = with_profile(observations)
    if not len(events):
        return None
    observed, sigma = expected.observed.copy(), expected.sigma.copy()
    draws = expected.draws.copy()
    for i in events:
        if observations.kind[i] == PLACE:
            continue
        smooth = observations.sites[observations.columns.path_index[i]].smooth
        y, s = expected.observed[i], expected.sigma[i]
        higher, record, lower = _places(smooth, np.array([y + s, y, y - s]))
        # What left the profile reached its end, on a counter-slope too.
        observed[i] = smooth.x_max if observations.kind[i] == LEFT else record
        sigma[i] = 0.5 * (lower - higher)
        draws[i] = np.where(expected.left[i], smooth.x_max, _places(smooth, expected.draws[i]))
    return replace(
        expected,
        observed=observed[events],
        sigma=sigma[events],
        draws=draws[events],
        left=expected.left[events],
        x=expected.x[events],
        sign=np.ones(len(events)),
    )


def x_scores(
    expected: ExpectedRecords, observations: Observations, floor: Floats
) -> RunoutScores | None:
    """`runout_scores` in x of the events with a profile; None without any."""
    found = in_x(expected, observations)
    if found is None:
        return None
    # What volumes do to the floor is in proportion to the errors of the records.
    wider = (floor / expected.sigma)[with_profile(observations)]
    pit = record_pit(found, generator(0, "scores in x"))
    return runout_scores(found, pit, found.sigma * wider)


def with_profile(observations: Observations) -> NDArray[np.int64]:
    """Indices of the events that have a profile."""
    return np.flatnonzero((observations.kind != LENGTH) & (observations.columns.path_index >= 0))


def _places(smooth: SmoothProfile, elevation: Floats) -> Floats:
    """x (m) `[n]` where the path first falls to elevations (m) `[n]`, its lowest place at most."""
    x = np.linspace(smooth.x_min, smooth.x_max, N_PLACES)
    lowest = np.minimum.accumulate(smooth.height(x))
    falling = np.concatenate([[True], np.diff(lowest) < 0.0])
    return np.asarray(np.interp(-elevation, -lowest[falling], x[falling]))
