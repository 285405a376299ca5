"""The posterior density against sums over fine grids (`naive_posterior`)."""

from __future__ import annotations

import sys
from types import FrameType
from typing import Any

import numpy as np
import pytest

from avahazard.inference.fitting.mode import start_coordinates
from avahazard.inference.likelihood import posterior as of_posterior
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import Arms
from avahazard.inference.model.specification import Specification
from avahazard.workers import set_workers
from tests.inference.naive_posterior import NaivePosterior
from tests.inference.studies import near, observations, posterior
from tests.workflow.twin import twin_study

MODELS: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "plain": ((), {}),
    "normal": ((), {"distribution": "normal"}),
    "student": ((), {"tails": "student"}),
    "power": ((), {"law": "power"}),
    "rational": ((), {"law": "rational"}),
    "constant": ((), {"law": "constant"}),
    "volume scatter": ((), {"scatter": "volume"}),
    "no curvature": ((), {"centrifugal": False}),
    "design": (("snow-type", "season", "covariate:wind"), {}),
    "limit": (("observation-limit",), {}),
    "epoch": (("epoch-bias",), {"distribution": "normal"}),
    "front": (("leading-edge",), {}),
    "drag": (("turbulent-drag", "forest-drag"), {}),
    "two kinds": (("two-kinds", "snow-type", "observation-limit"), {}),
    "two kinds, normal": (("two-kinds",), {"distribution": "normal"}),
    "two kinds, student": (("two-kinds",), {"tails": "student"}),
}
OFF_NEUTRAL = {
    "observation-limit.margin": 0.25,
    "epoch-bias.shift": 1.0,
    "leading-edge.share": 1.2,
    "turbulent-drag.drag": 0.26,
    "two-kinds.share": 1.2,
    "two-kinds.shift": -1.1,
    "forest-drag.drag": 0.35,
}


def _place(model: Posterior, seed: int) -> np.ndarray:
    """Plausible coordinates."""
    return near(model, 0.1, seed, **OFF_NEUTRAL)


@pytest.mark.parametrize("name", MODELS)
def test_every_event_has_its_marginal_likelihood(name: str) -> None:
    effects, settings = MODELS[name]
    model = posterior(observations(), *effects, **settings)
    for seed in range(2):
        u = _place(model, seed)
        # On tables made for u: what stands between others has tests of its own.
        assert model.pinned(u).event_log_likelihood(u) == pytest.approx(
            NaivePosterior(model, u).events(), abs=0.02
        )


def test_the_density_is_the_likelihood_times_the_prior() -> None:
    model = posterior(observations(), "release-elevation")
    u, other = _place(model, 1), _place(model, 2)
    slots = model.layout.slots
    apart = sum(
        -0.5 * ((u[k] - s.mean) ** 2 - (other[k] - s.mean) ** 2) / s.sd**2
        for k, s in enumerate(slots)
    )
    likelihood = sum(
        NaivePosterior(model, v).events().sum() * sign for v, sign in ((u, 1), (other, -1))
    )
    there, elsewhere = model.pinned(u), model.pinned(other)
    assert there.log_density(u) - elsewhere.log_density(other) == pytest.approx(
        likelihood + apart, abs=0.02
    )


@pytest.mark.parametrize(
    "effects", [(), ("turbulent-drag",), ("path-effect",), ("volume-error",), ("two-kinds",)]
)
@pytest.mark.parametrize("tails", ["normal", "student"])
def test_many_densities_at_once_are_those_of_each(effects: tuple[str, ...], tails: str) -> None:
    model = posterior(observations(), *effects, tails=tails)
    u = np.array([near(model, 0.1, seed) for seed in range(5)])
    u[3] = model.layout.low - 1.0
    whole, part = model, model.restricted(np.arange(model.observations.n_events) % 2 == 0)
    for one in (whole, part):
        assert one.log_densities(u) == pytest.approx([one.log_density(v) for v in u], abs=1e-9)


@pytest.mark.parametrize("effects", [(), ("turbulent-drag",), ("path-effect",)])
def test_more_events_than_fit_at_once_go_one_density_at_a_time(
    effects: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As 20,000 events do where each density has nodes of its own."""
    model = posterior(observations(), *effects)
    u = np.array([near(model, 0.1, seed) for seed in range(3)])
    whole = model.log_densities(u)
    monkeypatch.setattr("avahazard.inference.likelihood.posterior.MOST_NUMBERS", 7)
    assert model.log_densities(u) == pytest.approx(whole, abs=1e-9)
    assert model.log_densities(u[:1]) == pytest.approx(whole[:1], abs=1e-9)


def test_out_of_bounds_there_is_no_density() -> None:
    model = posterior(observations(), "cohesion")
    u = _place(model, 0)
    u[[s.name for s in model.layout.slots].index("cohesion.strength")] = -0.01
    assert model.log_density(u) == -np.inf
    # A walk asks so where all of its steps lead out of bounds.
    assert model.log_densities(np.array([u, u])).tolist() == [-np.inf, -np.inf]


@pytest.mark.parametrize(
    ("settings", "tau", "tolerance"),
    [
        ({}, 0.1, 0.004),
        pytest.param({}, 1.5, 0.03, marks=pytest.mark.slow),
        # Laplace's method knows nothing of heavy tails.
        pytest.param({"tails": "student"}, 0.5, 0.15, marks=pytest.mark.slow),
        ({"distribution": "normal"}, 0.5, 0.06),
        ({"effects": ("two-kinds",)}, 0.5, 0.1),
    ],
)
def test_path_offsets_are_integrated_out(
    settings: dict[str, Any], tau: float, tolerance: float
) -> None:
    more = dict(settings)
    model = posterior(observations(30), "path-effect", *more.pop("effects", ()), **more)
    u = _place(model, 0)
    u[model.layout.spreads["path-effect"]] = tau
    slow = NaivePosterior(model, u).by_paths(0.2 * tau)
    assert model.pinned(u).log_likelihood(u) == pytest.approx(slow, abs=tolerance)


def test_offsets_have_the_mean_and_spread_of_their_conditional_distribution() -> None:
    model = posterior(observations(), "path-effect")
    u = _place(model, 0)
    tau = 0.2 * u[model.layout.spreads["path-effect"]]
    offsets = model.offsets(u)
    grid = np.linspace(-0.6, 0.6, 241)
    logs = np.array([model.event_log_likelihood(u, np.full(6, d)) for d in grid])
    for k in range(6):
        path = logs[:, model.plan.index[0] == k].sum(axis=1) - 0.5 * (grid / tau) ** 2
        weight = np.exp(path - path.max())
        mean = np.sum(weight * grid) / np.sum(weight)
        sd = np.sqrt(np.sum(weight * (grid - mean) ** 2) / np.sum(weight))
        assert offsets.mode[k] == pytest.approx(mean, abs=0.15 * sd)
        assert offsets.bend[k] ** -0.5 == pytest.approx(sd, rel=0.05)


def test_a_restricted_posterior_knows_a_part_of_the_events() -> None:
    model = posterior(observations())
    keep = np.arange(observations().n_events) % 3 != 0
    u = _place(model, 0)
    part = model.restricted(keep)
    assert part.log_likelihood(u) == pytest.approx(model.event_log_likelihood(u)[keep].sum())
    again = part.on_star(Arms({"log track sigma": (-3.0, -2.0, -1.0)}))
    fine = part.on_star(Arms({"log track sigma": (float(u[-1]), -4.5, -1.0)}))
    assert fine.log_likelihood(u) == part.exact_log_likelihood(u)
    assert again.layout.high[-1] == -1.0


@pytest.mark.parametrize("effects", [("turbulent-drag", "snow-type"), ("path-effect",)])
def test_a_model_of_a_part_of_the_events_is_that_of_all(effects: tuple[str, ...]) -> None:
    """With their tracks; in another order, of some paths alone."""
    model = posterior(observations(), *effects)
    path = model.observations.columns.path_index
    events = np.flatnonzero(np.isin(path, (1, 3)))[::-1]
    part, u = model.of_part(events), _place(model, 0)
    tracks = [track.event for track in model.observations.speeds]
    assert len(part.observations.speeds) == len(np.intersect1d(tracks, events)) > 0
    assert len(part.observations.sites) == 2
    offsets = there = None
    if model.plan:
        of = dict(zip(model.plan.names, 0.1 * np.arange(len(model.plan.names)), strict=True))
        offsets = np.array([*of.values()])
        there = np.array([of[name] for name in part.plan.names])
    expected = model.pinned(u).event_log_likelihood(u, offsets)[events]
    found = part.pinned(u).event_log_likelihood(u, there)
    assert found == pytest.approx(expected, abs=1e-9)


def test_paths_without_events_left_keep_a_prior_offset() -> None:
    model = posterior(observations(), "path-effect")
    u = _place(model, 0)
    tau = 0.2 * u[model.layout.spreads["path-effect"]]
    offsets = model.restricted(model.plan.index[0] != 2).offsets(u)
    assert offsets.mode[2] == 0.0
    assert offsets.bend[2] ** -0.5 == pytest.approx(tau)


def test_a_spread_of_nothing_between_paths_is_approached() -> None:
    model, base = posterior(observations(), "path-effect"), posterior(observations())
    u = _place(model, 0)
    place = model.layout.spreads["path-effect"]
    without = base.log_likelihood(np.delete(u, place))
    u[place] = 0.005
    assert model.log_likelihood(u) == pytest.approx(without, abs=1e-3)
    u[place] = 0.0
    assert model.log_likelihood(u) == without


def test_scatter_that_falls_with_volume_stays_where_nodes_bear_it() -> None:
    model = posterior(observations(), scatter="volume")
    u = near(model)
    u[model.layout.scatter_slope] = 4.0
    volume = np.full((model.observations.n_events, 1), 50.0 * model.layout.reference_volume)
    _, scatter = model.friction.location_and_scatter(u, volume, model.of_events)
    assert np.exp(model.layout.slots[model.layout.scatter].low) == pytest.approx(scatter)


@pytest.mark.parametrize("slope", [-2.0, 1.0])
def test_scatter_beyond_the_reference_volume_is_that_at_it(slope: float) -> None:
    """It neither explodes nor vanishes where no event has been."""
    model = posterior(observations(), scatter="volume")
    u = near(model)
    u[model.layout.scatter_slope] = slope
    shares = np.array([0.0, 0.5, 1.0, 1.01, 5.0, 1e6])
    volume = shares * model.layout.reference_volume + 1e-9
    volume = np.tile(volume, (model.observations.n_events, 1))
    _, scatter = model.friction.location_and_scatter(u, volume, model.of_events)
    sigma = np.exp(u[model.layout.scatter])
    np.testing.assert_allclose(scatter[0], sigma * np.exp(-slope * np.minimum(shares, 1.0)))
    columns = model.observations.columns
    at = volume[0, 4:5].repeat(len(volume))
    _, many = model.friction.of_future_events(u[None], at, columns)
    np.testing.assert_allclose(many, scatter[0, 4])


def test_winters_that_nobody_knows_add_to_the_scatter() -> None:
    model = posterior(observations(), "winter-effect")
    u = near(model, **{"log sigma": np.log(0.15), "tau_winter": 1.0})
    index, alone = model.plan.index[0], model.plan.alone[0]
    assert np.array_equal(alone, index < 0)
    assert alone.any()
    assert not alone.all()
    scatter = model.location_and_scatter(u)[1][:, 0]
    np.testing.assert_allclose(scatter[~alone], 0.15)
    np.testing.assert_allclose(scatter[alone], np.hypot(0.15, 0.2))
    # What is to come is in none that is known, whatever its date.
    volume = np.full(model.observations.n_events, 1e4)
    columns = model.observations.columns
    to_come = model.friction.of_future_events(u[None], volume, columns)[1][0]
    np.testing.assert_allclose(to_come, np.hypot(0.15, 0.2))


def test_groups_of_two_kinds_are_integrated_out_together() -> None:
    """Against a normal sample of the offsets, the mean of the likelihood."""
    model = posterior(observations(), "path-effect", "storm-effect")
    u = near(model, **{"tau": 0.2, "tau_storm": 0.3})
    rng = np.random.default_rng(3)
    given = model.offsets(u)
    # Importance sampling from the normal about the mode.
    draws = np.array([given.draw(rng) for _ in range(400)])
    spread = model.layout.spread_values(u)[model.plan.of]
    away = draws - given.mode
    precision = np.linalg.inv(np.cov(np.array([given.draw(rng) for _ in range(20000)]).T))
    log_q = 0.5 * np.linalg.slogdet(precision)[1] - 0.5 * np.sum(away @ precision * away, axis=1)
    log_p = -0.5 * np.sum((draws / spread) ** 2, axis=1) - np.sum(np.log(spread))
    logs = np.array([model.event_log_likelihood(u, row).sum() for row in draws]) + log_p - log_q
    expected = float(np.log(np.mean(np.exp(logs - logs.max()))) + logs.max())
    assert model.log_likelihood(u) == pytest.approx(expected, abs=0.15)


@pytest.mark.parametrize("effects", [(), ("path-effect",), ("turbulent-drag",)])
def test_densities_are_the_same_by_any_number_of_threads(
    effects: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(of_posterior, "WORTH_SHARING", 0)
    model = posterior(observations(), *effects)
    u = np.array([_place(model, seed) for seed in range(9)])
    found = []
    try:
        for workers in (1, 2, 7):
            set_workers(workers)
            found.append(model.log_densities(u))
    finally:
        set_workers(None)
    assert np.isfinite(found[0]).all()
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])


@pytest.mark.parametrize(
    "name", [*MODELS, "volume errors", "student power", "paths", "grouped", "storms", "all groups"]
)
def test_exact_slopes_are_what_differences_go_to(name: str) -> None:
    more: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
        "volume errors": (("volume-error",), {}),
        "student power": ((), MIXED),
        "paths": (("path-effect", "snow-type"), {}),
        "grouped": (("path-effect", "two-kinds", "observation-limit"), MIXED),
        "storms": (("storm-effect",), {}),
        "all groups": (("path-effect", "storm-effect", "two-kinds"), MIXED),
    }
    effects, settings = {**MODELS, **more}[name]
    model = posterior(observations(), *effects, **settings)
    part = model.restricted(np.arange(model.observations.n_events) % 3 > 0)
    for whole in (model, part):
        u = np.maximum(_place(model, 3), model.layout.low + 1e-4)
        value, slopes = whole.density_and_slopes(u)
        assert value == pytest.approx(whole.log_density(u), rel=1e-13)
        for k in whole.sloped:
            step = 1e-5 * np.eye(len(u))[k]
            apart = whole.log_density(u + step) - whole.log_density(u - step)
            assert slopes[k] == pytest.approx(apart / 2e-5, rel=1e-5, abs=1e-3)


MIXED = {"law": "power", "tails": "student", "scatter": "volume"}


def test_slots_of_tables_and_of_volumes_have_no_exact_slopes() -> None:
    model = posterior(observations(), "turbulent-drag", "snow-type", "volume-error")
    held = [
        model.layout.slots[k].name for k in set(range(len(model.layout.slots))) - set(model.sloped)
    ]
    assert {"turbulent-drag.drag", "volume-error.log_factor"} <= set(held)
    assert not any(name.startswith("snow-type") for name in held)
    # Beside groups not where the log of friction is not what they shift.
    assert len(posterior(observations(), "storm-effect").sloped) == 4
    assert len(posterior(observations(), "path-effect", distribution="normal").sloped) == 0


@pytest.mark.parametrize("effects", [(), ("path-effect",), ("turbulent-drag", "record-error")])
def test_one_call_is_at_most_8_frames_deep(effects: tuple[str, ...]) -> None:
    """On the data of the demo, numpy's frames among them; star and chart are made before."""
    specification, facts = with_effects(twin_study(), Specification(), effects)
    model = assemble(twin_study(), specification, facts)
    u = start_coordinates(model)
    model.log_density(u)
    elsewhere = np.clip(u + 1e-5, model.layout.low, model.layout.high)
    deep = [0]

    def told(_frame: FrameType, event: str, _arg: object) -> None:
        deep.append(deep[-1] + {"call": 1, "return": -1}.get(event, 0))

    sys.setprofile(told)
    try:
        value = model.log_density(elsewhere)
    finally:
        sys.setprofile(None)
    assert np.isfinite(value)
    assert max(deep) <= 8
