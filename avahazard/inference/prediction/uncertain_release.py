"""Events whose release is not known well, as the same events from the releases that it may be.

The stop of the avalanche itself, not a record of it: the error of the release goes through the run
of the block, however much F bends, and wherever friction goes by the release.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.model.observations import LENGTH, Observations
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.prediction.stops import predict_stops
from avahazard.records.event import Event

Stops = tuple[Floats, NDArray[np.bool_]]
"""Where events stop (m, or H/L) and whether they left their profile, `[n_events, n_draws]` each."""

N_RELEASES = 25
AT_ONCE = 20
"""Events that are run from all their releases at once: memory."""
LEAST_FALL = 1e-3
"""Share of the fall that is left at least, on a straight line."""


def stops_over_releases(
    on: Callable[[Sequence[Event]], FittedModel],
    events: Sequence[Event],
    sigma: Floats,
    n_draws: int,
    rng: np.random.Generator,
) -> Stops:
    """Draws of where events stop whose releases are off by `sigma` `[n_events]` (m of elevation).

    `on` gives the model on events of its paths. Each draw starts from one of `N_RELEASES` places,
    as likely each.
    """
    values, left = np.empty((len(events), n_draws)), np.empty((len(events), n_draws), np.bool_)
    known = on(events).observations
    for first in range(0, len(events), AT_ONCE):
        mine = range(first, min(first + AT_ONCE, len(events)))
        copies = [copy for i in mine for copy in from_each_release(events[i], sigma[i], known, i)]
        model = on(copies)
        stops = predict_stops(model, n_draws, rng)
        there = told(model.observations, stops.record, stops.elevation)
        for k, i in enumerate(mine):
            # Draws run through the posterior in order; their releases must not.
            start = k * N_RELEASES + rng.permutation(np.arange(n_draws) % N_RELEASES)
            values[i] = there[start, np.arange(n_draws)]
            left[i] = stops.left[start, np.arange(n_draws)]
    return values, left


def told(observations: Observations, record: Floats, elevation: Floats) -> Floats:
    """Elevations, or without a profile lengths or H/L, `[n_events, n_draws]`."""
    lengths = observations.kind == LENGTH
    return np.where(lengths[:, None], observations.as_recorded(record), elevation)


def from_each_release(
    event: Event, sigma: float, observations: Observations, i: int
) -> list[Event]:
    """The event, number `i` of the observations, from each release within its error `sigma` (m).

    On a straight line the fall changes, else the elevation of the start; over the top of the
    profile is its top.
    """
    places = sigma * normal_places(N_RELEASES)
    if event.path_id is None:
        fall = float(observations.fall_height[i])
        return [
            replace(event, fall_height_m=max(fall + float(z), LEAST_FALL * fall)) for z in places
        ]
    height = float(observations.columns.release_elevation[i])
    return [replace(event, release_elevation_m=height + float(z)) for z in places]


def normal_places(n: int) -> Floats:
    """Middles `[n]` of equal shares of the standard normal, stretched to its variance."""
    from scipy.stats import norm  # noqa: PLC0415 (slow)

    places = norm.ppf((np.arange(n) + 0.5) / n)
    return np.asarray(places / np.sqrt(np.mean(places**2)))
