"""A path on a parabola, and avalanches on it by a model of which everything is known."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from avahazard.effects.effect import Effect
from avahazard.hazard import rows
from avahazard.hazard.exceedance import Avalanches
from avahazard.hazard.extremes import EventVolumes
from avahazard.hazard.future_events import FutureEvents
from avahazard.hazard.path_hazard import PathHazard, hazard_of_events
from avahazard.hazard.rows import Scenario, Weighted, hazard_row, volume_stops
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.choices import MethodName
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.notes import Note
from avahazard.physics.block import run
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.results.hazard import HazardRow

LAW = np.array([np.log(0.7), 2.0])  # log a, n in 1e-6/m3
TOP_M = 2450.0


@cache
def observations(releases: tuple[float, ...] = (TOP_M,)) -> Observations:
    """An event to come from each release (m), on a parabola 3600 m long."""
    x = np.arange(0.0, 3601.0, 30.0)
    y = 2500.0 - 0.9 * x + 1.2e-4 * x**2
    events = tuple(
        Event(f"e{k}", path_id="p", volume_m3=1e5, release_elevation_m=z)
        for k, z in enumerate(releases)
    )
    return build_observations(Records((Path("p"),), (Profile("p", x, y),), events))


def future(releases: Sequence[float] = (TOP_M,)) -> FutureEvents:
    """The same events as classes of future avalanches."""
    given = observations(tuple(releases))
    return FutureEvents(given.sites[0], given.release, given.columns)


def draws(sigma: float, n: int, *more: float) -> np.ndarray:
    """A posterior that knows everything: equal draws."""
    return np.tile(np.concatenate([LAW, [np.log(sigma)], more]), (n, 1))


def path(
    coordinates: np.ndarray,
    volumes: EventVolumes | None,
    releases: Sequence[float] = (TOP_M,),
    specification: Specification | None = None,
    effects: tuple[Effect, ...] = (),
    metres: bool = False,
    at: Sequence[float] = (),
) -> PathHazard:
    posterior = Posterior(observations(tuple(releases)), specification or Specification(), effects)
    method: MethodName = "metropolis" if metres else "marginal"
    model = fitted_model(posterior, coordinates, {}, method)
    return hazard_of_events(model, future(releases), volumes, at, seed=3)


def avalanches_of(
    coordinates: np.ndarray,
    volumes: EventVolumes,
    releases: Sequence[float] = (TOP_M,),
    **more: Any,
) -> Avalanches:
    return path(coordinates, volumes, releases, **more).avalanches


def stop(mu: float, release_m: float = TOP_M) -> float:
    """Where one run of the block stops, x in m."""
    site = observations((release_m,)).sites[0]
    cells = build_cells(site.terrain, no_resistance(site.terrain))
    start = np.array([site.terrain.node(site.release_x[0])])
    return float(run(cells, start, np.array([mu])).x[0, 0])


def stops(mu: np.ndarray, release_m: float) -> np.ndarray:
    """Stops x (m) of many frictions, between single runs; inf past the end."""
    grid = np.linspace(0.2, 1.0, 401)
    site = observations((release_m,)).sites[0]
    cells = build_cells(site.terrain, no_resistance(site.terrain))
    start = np.array([site.terrain.node(site.release_x[0])])
    found = run(cells, start, grid).x[0]
    inside = np.isfinite(found)
    return np.where(mu < grid[inside][0], np.inf, np.interp(mu, grid[inside], found[inside]))


def volume_bounds(
    given: PathHazard, volume_m3: float, n_draws: int, rng: np.random.Generator
) -> HazardRow:
    """The row of a volume, as far as it is a summary of stops."""
    stops = volume_stops(given, volume_m3, n_draws, rng)
    return hazard_row(Scenario("p", volume_m3), *stops, n_draws, Note("of_parameters"))


def path_rows(
    given: PathHazard, scenarios: Sequence[Scenario], n_draws: int, seed: int
) -> list[HazardRow]:
    """The rows of a path by one model."""
    return rows.path_rows([Weighted("", 1.0, given)], scenarios, n_draws, seed)
