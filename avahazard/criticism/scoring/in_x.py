"""Expected records as places along the path, whatever coordinate was recorded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.criticism.scoring.error_budget import ErrorBudget
from avahazard.criticism.scoring.expected import ExpectedRecords
from avahazard.criticism.scoring.scores import record_pit, runout_scores
from avahazard.inference.model.observations import LEFT, LENGTH, PLACE, Observations
from avahazard.inference.seeds import generator
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.results.comparison import RunoutScores

N_PLACES = 4001


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
    expected: ExpectedRecords, observations: Observations, budget: ErrorBudget
) -> RunoutScores | None:
    """The scores in x of the events with a profile; None without any."""
    found = in_x(expected, observations)
    if found is None:
        return None
    # What volumes do to the floor is in proportion to the errors of the records.
    wider = (budget.floor / expected.sigma)[with_profile(observations)]
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
