"""Runout bounds of avalanches to come, by the posterior draws of a calibrated model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.elevation_scatter import scattered_stops
from avahazard.hazard.posterior_draws import PosteriorDraws, posterior_draws
from avahazard.hazard.runout_bounds import RunoutBounds, bounds_of_stops, draw_runouts
from avahazard.hazard.runout_curve import RunoutCurve
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.physics.block import NOT_RELEASED
from avahazard.physics.runout_table import MU, MU_STEP

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MAX_PARAMETERS = 4000
"""Posterior draws that are used, evenly, of those given."""
STUDENT_DF = 4


@dataclass(frozen=True, slots=True)
class FutureEvent:
    """An avalanche to come: `volume_m3` on a path, None where the model has no use for it.

    `events` are indices of the observations that it may be like (their columns matter to some
    effects); every draw takes one of them.
    """

    path_id: str
    volume_m3: float | None
    events: Indices


@dataclass(frozen=True, slots=True, eq=False)
class Forecaster:
    """Posterior draws of friction for observations of avalanches to come.

    `location`, `scatter` `[n_parameters, n_events]` as `Posterior.location_and_scatter`, in the
    order of `draws`. `sigma_m` `[n_parameters]` is the scatter in metres of the metropolis
    method, else None.
    """

    posterior: Posterior
    location: Floats
    scatter: Floats
    draws: PosteriorDraws
    sigma_m: Floats | None


def forecaster(model: FittedModel, volume: Floats) -> Forecaster:
    """Prepare the draws of a model for its events, of `volume` (m3) `[n_events]`, exact.

    What shifts records alone is left out: bounds are of true stops.
    """
    posterior = model.posterior
    draws = posterior_draws(model, MAX_PARAMETERS)
    pairs = [posterior.location_and_scatter(row, volume[:, None]) for row in draws.u]
    return Forecaster(
        posterior=posterior,
        location=np.array([location[:, 0] for location, _ in pairs]),
        scatter=np.array([scatter[:, 0] for _, scatter in pairs]),
        draws=draws,
        sigma_m=draws.sigma_m,
    )


def future_bounds(
    ready: Forecaster, future_event: FutureEvent, n_draws: int, rng: np.random.Generator
) -> RunoutBounds:
    """Bounds of the runout of one future_event, from `n_draws` draws over the posterior."""
    n = len(ready.location)
    parameter = np.arange(n_draws) * n // n_draws
    event = future_event.events[rng.integers(len(future_event.events), size=n_draws)]
    location = ready.location[parameter, event]
    shift = ready.draws.path_shift(future_event.path_id, rng)
    specification = ready.posterior.specification
    if ready.posterior.layout.log_scatter:
        friction = np.exp(location + shift[parameter])
    else:
        friction = location * np.exp(shift[parameter])
    scatter = ready.scatter[parameter, event]
    if specification.tails == "student":
        # Student's t is a normal whose variance is drawn.
        scatter = scatter * np.sqrt(STUDENT_DF / rng.chisquare(STUDENT_DF, n_draws))
    if ready.sigma_m is not None:
        scatter = np.zeros(n_draws)
    xs, ys, held = [], [], 0
    kinds = _kinds(ready, future_event.events)
    group = ready.draws.group[parameter]
    for g, tables in enumerate(ready.draws.tables):
        for kind in np.unique(kinds):
            mine = (group == g) & (kinds[np.searchsorted(future_event.events, event)] == kind)
            if not mine.any():
                continue
            curve = _curve(tables, int(event[mine][0]))
            x, y, counts = draw_runouts(
                curve,
                friction[mine],
                scatter[mine],
                specification.distribution,
                int(mine.sum()),
                rng,
            )
            if ready.sigma_m is not None:
                x, y, n_held = _scattered(ready, future_event, y, parameter[mine], rng)
                counts[NOT_RELEASED] = n_held
            xs.append(x)
            ys.append(y)
            held += int(counts[NOT_RELEASED])
    return bounds_of_stops(np.concatenate(xs), np.concatenate(ys), held, n_draws)


def _kinds(ready: Forecaster, events: Indices) -> Indices:
    """A number for each of `events`: those with one number have the same tables."""
    whole = ready.draws.tables[len(ready.draws.tables) // 2].x[events]
    _, kinds = np.unique(whole, axis=0, return_inverse=True)
    return np.asarray(kinds.ravel(), np.int64)


def _curve(tables: Predicted, event: int) -> RunoutCurve:
    return RunoutCurve(
        float(MU[0]), MU_STEP, tables.x[event], tables.elevation[event], tables.status[event]
    )


def _scattered(
    ready: Forecaster,
    future_event: FutureEvent,
    y: Floats,
    parameter: Indices,
    rng: np.random.Generator,
) -> tuple[Floats, Floats, int]:
    assert ready.sigma_m is not None
    observations = ready.posterior.observations
    event = int(future_event.events[0])
    site = observations.sites[observations.columns.path_index[event]]
    release = float(site.release_x[observations.release[event]])
    return scattered_stops(site.smooth, release, y, ready.sigma_m[parameter], rng)
