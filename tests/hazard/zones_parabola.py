"""Future avalanches on a parabola, and runs of the block on it."""

from __future__ import annotations

from functools import cache

import numpy as np

from avahazard.effects.effect import Effect
from avahazard.hazard.exceedance import Avalanches
from avahazard.hazard.extremes import EventVolumes
from avahazard.hazard.future_events import FutureEvents
from avahazard.hazard.path_hazard import hazard_of_events
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.speed import speeds_along
from avahazard.records.collection import Event, Path, Profile, Records

LAW = np.array([np.log(0.7), 2.0])  # log a, n in 1e-6/m3
X = np.linspace(0.0, 3600.0, 61)
VOLUMES = np.log([1e4, 1e5, 2.5e5])
SHARES = np.array([[0.6, 0.3, 0.1], [0.2, 0.5, 0.3]])
RATES = np.array([0.5, 2.0])


@cache
def observations(*releases: float, length: float | None = None) -> Observations:
    """One class of future avalanches for each elevation of release, on a parabola."""
    x = np.arange(0.0, 3601.0, 30.0)
    events = tuple(
        Event(f"e{k}", path_id="p", volume_m3=1e5, release_elevation_m=z, deposit_length_m=length)
        for k, z in enumerate(releases)
    )
    y = 2500.0 - 0.9 * x + 1.2e-4 * x**2
    return build_observations(Records((Path("p"),), (Profile("p", x, y),), events))


def avalanches_of(
    draws: np.ndarray,
    volumes: EventVolumes,
    releases: tuple[float, ...] = (2450.0,),
    specification: Specification | None = None,
    effects: tuple[Effect, ...] = (),
    length: float | None = None,
) -> Avalanches:
    given = observations(*releases, length=length)
    future = FutureEvents(given.sites[0], given.release, given.columns)
    posterior = Posterior(given, specification or Specification(), effects)
    model = fitted_model(posterior, draws, {})
    return hazard_of_events(model, future, volumes, seed=1).avalanches


def one(sigma: float, n: int = 3, *more: float) -> np.ndarray:
    return np.tile(np.concatenate([LAW, [np.log(sigma)], more]), (n, 1))


def block_speeds(mu: float | np.ndarray, release_m: float = 2450.0) -> np.ndarray:
    """Speeds at X of single runs of the block, `[n_mu, n_x]`."""
    site = observations(release_m).sites[0]
    cells = build_cells(site.terrain, no_resistance(site.terrain))
    start = site.terrain.node(site.release_x[0])
    return np.asarray(speeds_along(cells, start, np.atleast_1d(mu), X))
