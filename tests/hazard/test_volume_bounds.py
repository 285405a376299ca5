"""Bounds of one volume, against single runs of the block."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.effects.effect import Effect
from avahazard.hazard.future_events import FutureEvents
from avahazard.hazard.path_hazard import PathHazard, hazard_of_events
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.choices import MethodName
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.physics.block import run
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.results.hazard import HazardRow
from tests.hazard.parabola import volume_bounds

VOLUME = 1e5
LAW = np.array([np.log(0.7), 2.0])  # log a, n in 1e-6/m3
MEDIAN = 0.7 * np.exp(-0.2)


@cache
def observations(*lengths: float) -> Observations:
    """One event to come for each length of deposit, or one without; on a parabola."""
    x = np.arange(0.0, 3601.0, 30.0)
    y = 2500.0 - 0.9 * x + 1.2e-4 * x**2
    events = tuple(
        Event(f"e{k}", path_id="p", volume_m3=VOLUME, deposit_length_m=length)
        for k, length in enumerate(lengths or (None,))
    )
    path = Path("p", release_elevation_m=2450.0)
    return build_observations(Records((path,), (Profile("p", x, y),), events))


def path_of(
    draws: np.ndarray,
    specification: Specification | None = None,
    effects: tuple[Effect, ...] = (),
    lengths: tuple[float, ...] = (),
    offsets: dict[str, np.ndarray] | None = None,
    method: MethodName = "marginal",
) -> PathHazard:
    given = observations(*lengths)
    future = FutureEvents(given.sites[0], given.release, given.columns)
    posterior = Posterior(given, specification or Specification(), effects)
    model = fitted_model(posterior, draws, offsets or {}, method)
    return hazard_of_events(model, future, None, [VOLUME], seed=0)


def bounds(path: PathHazard, n_draws: int = 40_000) -> HazardRow:
    return volume_bounds(path, VOLUME, n_draws, np.random.default_rng(11))


def one(sigma: float, *more: float) -> np.ndarray:
    """A posterior that knows everything: ten equal draws."""
    return np.tile(np.concatenate([LAW, [np.log(sigma)], more]), (10, 1))


def stop(mu: float) -> tuple[float, float]:
    """Stop x, y of one run of the block."""
    site = observations().sites[0]
    cells = build_cells(site.terrain, no_resistance(site.terrain))
    stops = run(cells, np.array([site.terrain.node(site.release_x[0])]), np.array([mu]))
    return float(stops.x[0, 0]), float(stops.y[0, 0])


def test_quantiles_are_runs_at_the_quantiles_of_friction() -> None:
    found = bounds(path_of(one(0.1)))
    for z, x, y in (
        (1.645, found.runout_x_m.q05, found.runout_elevation_m.q95),
        (0.0, found.runout_x_m.q50, found.runout_elevation_m.q50),
        (-1.645, found.runout_x_m.q95, found.runout_elevation_m.q05),
    ):
        expected = stop(MEDIAN * np.exp(0.1 * z))
        assert x == pytest.approx(expected[0], abs=10.0)
        assert y == pytest.approx(expected[1], abs=5.0)
    assert found.p_left_profile < 0.01


def test_uncertainty_of_the_parameters_widens() -> None:
    rng = np.random.default_rng(2)
    draws = one(0.05).repeat(200, axis=0)
    draws[:, 0] += 0.1 * rng.standard_normal(len(draws))
    wide, narrow = bounds(path_of(draws)), bounds(path_of(one(0.05)))
    ratio = (wide.runout_elevation_m.q95 - wide.runout_elevation_m.q05) / (
        narrow.runout_elevation_m.q95 - narrow.runout_elevation_m.q05
    )
    assert ratio == pytest.approx(np.hypot(0.1, 0.05) / 0.05, rel=0.05)


def test_the_offset_of_a_known_path_and_the_spread_of_an_unknown_one() -> None:
    effect = definition("path-effect").build({})
    draws = one(0.02, 0.5).repeat(100, axis=0)  # tau = 0.1
    known = bounds(path_of(draws, effects=(effect,), offsets={"p": np.full(1000, -0.15)}))
    assert known.runout_x_m.q50 == pytest.approx(stop(MEDIAN * np.exp(-0.15))[0], abs=8.0)
    unknown = bounds(path_of(draws, effects=(effect,)))
    assert unknown.runout_x_m.q95 == pytest.approx(
        stop(MEDIAN * np.exp(-1.645 * 0.102))[0], rel=0.03
    )


def test_drag_stays_with_the_friction_that_it_was_drawn_with() -> None:
    # Friction falls where drag rises: apart from each other they would spread far wider.
    rng = np.random.default_rng(4)
    effect = definition("turbulent-drag").build({})
    scale = effect.parameters[0].prior_sd
    drag = rng.uniform(0.0005, 0.003, 300)
    draws = np.column_stack(
        [np.log(0.7) - 120.0 * drag, np.full(300, 2.0), np.full(300, np.log(1e-3)), drag / scale]
    )
    found = bounds(path_of(draws, effects=(effect,)), 30_000)
    stops = []
    for row in draws:
        table = predict_records(observations(), (effect,), {"turbulent-drag": row[3:] * scale})
        stops.append(np.interp(np.exp(row[0] - 0.2), MU, table.x[0]))
    expected = np.quantile(stops, [0.05, 0.5, 0.95])
    assert (found.runout_x_m.q05, found.runout_x_m.q50, found.runout_x_m.q95) == pytest.approx(
        expected, abs=12.0
    )


def test_the_front_is_ahead_by_the_deposits_of_the_records() -> None:
    effect = definition("leading-edge").build({})
    share = 0.5 / effect.parameters[0].prior_sd
    found = bounds(path_of(one(1e-3, share), effects=(effect,), lengths=(100.0, 300.0)))
    block = stop(MEDIAN)[0]
    assert 40.0 < found.runout_x_m.q05 - block < 50.0
    assert 120.0 < found.runout_x_m.q95 - block < 150.0


def test_what_moves_records_alone_moves_no_stop() -> None:
    effect = replace(definition("epoch-bias").build({"years": [1900.0]}), shift=_far)
    draws = one(0.1, *(p.neutral / p.prior_sd for p in effect.parameters))
    draws[:, 3] = 1.0
    assert bounds(path_of(draws, effects=(effect,))) == bounds(path_of(one(0.1)))


def _far(columns: object, values: object) -> np.ndarray:
    del columns, values
    return np.full(1, 500.0)


def test_students_tails_are_heavier_at_one_scale() -> None:
    normal = bounds(path_of(one(0.1)))
    student = bounds(path_of(one(0.1), Specification(tails="student")))
    assert student.runout_x_m.q50 == pytest.approx(normal.runout_x_m.q50, abs=5.0)
    # The 95 % point of Student's t with 4 degrees of freedom is 2.132.
    assert student.runout_x_m.q95 == pytest.approx(stop(MEDIAN * np.exp(-0.2132))[0], rel=0.01)


def test_normal_friction_counts_what_cannot_be() -> None:
    found = bounds(path_of(one(0.35), Specification(distribution="normal")))
    # P(0.573 + 0.35 z <= 0)
    assert found.n_nonpositive_friction / found.n_draws == pytest.approx(0.0508, abs=0.004)


def test_scatter_in_metres_is_about_the_blocks_stop() -> None:
    found = bounds(path_of(one(40.0), method="metropolis"))
    y = stop(MEDIAN)[1]
    assert found.runout_elevation_m.mean == pytest.approx(y, abs=1.5)
    assert found.runout_elevation_m.q95 - y == pytest.approx(1.645 * 40.0, rel=0.02)
    assert found.runout_x_m.q50 == pytest.approx(stop(MEDIAN)[0], abs=4.0)


def test_equal_generators_give_equal_bounds() -> None:
    assert bounds(path_of(one(0.1))) == bounds(path_of(one(0.1)))
