"""Draws of stops, and how far a volume lies beyond the records."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from avahazard.hazard.path_hazard import path_hazard
from avahazard.inference import prediction as stops
from avahazard.inference.fitted_model import FittedModel, fitted_model, table_groups
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction import drawn_frictions, extrapolation, look_up, predict_stops
from avahazard.physics.runout_curve import MU, MU_STEP
from avahazard.records.collection import Event, Path, Profile, Records
from tests.hazard.parabola import volume_bounds
from tests.inference.studies import near, observations, posterior
from tests.physics.naive import naive_stop


def test_every_draw_is_in_one_group() -> None:
    parameters = np.random.default_rng(1).standard_normal((1000, 2))
    groups = table_groups(parameters, 32)
    assert len(groups) == 32
    assert sorted(np.concatenate(groups).tolist()) == list(range(1000))


def test_groups_of_one_parameter_are_slices_of_its_order() -> None:
    parameters = np.random.default_rng(2).lognormal(size=(640, 1))
    groups = table_groups(parameters, 16)
    lows = [parameters[g].min() for g in groups]
    highs = [parameters[g].max() for g in groups]
    order = np.argsort(lows)
    assert all(highs[i] <= lows[j] for i, j in pairwise(order))


@pytest.mark.parametrize("n_parameters", [1, 2])
def test_what_goes_along_with_the_tables_is_kept(n_parameters: int) -> None:
    parameters = np.random.default_rng(3).standard_normal((4000, n_parameters))
    groups = table_groups(parameters, 32)
    within = np.mean([parameters[g].var(axis=0) for g in groups])
    assert within < 0.02 * n_parameters**4


def test_nothing_to_split() -> None:
    assert len(table_groups(np.empty((50, 0)), 32)) == 1
    assert len(table_groups(np.full((50, 2), 0.3), 32)) == 1
    assert len(table_groups(np.repeat([[0.0], [1.0]], 5, axis=0), 32)) == 2


N, RNG = 4000, np.random.default_rng


@cache
def records() -> Records:
    """One stop by place, one by elevation."""
    x = np.linspace(0.0, 1600.0, 161)
    slope = np.select([x < 500.0, x < 650.0, x < 1000.0], [0.7, 0.0, 0.7], 0.1)
    y = 1200.0 - np.concatenate([[0.0], np.cumsum(slope[:-1] * np.diff(x))])
    events = (
        Event("a", "T", runout_x_m=600.0, runout_sigma_m=1e-9),
        Event("b", "T", runout_elevation_m=850.0, runout_sigma_m=1e-9),
    )
    return Records((Path("T"),), (Profile("T", x, y),), events)


@cache
def model() -> Posterior:
    """Friction scatters about a constant."""
    return Posterior(build_observations(records()), Specification(law="constant"), ())


def coordinates() -> np.ndarray:
    """Friction close about that of the jump."""
    _, low, high = gap()
    u = np.array([0.0 if np.isnan(s.neutral) else s.neutral for s in model().layout.slots])
    u[0], u[model().layout.scatter] = np.log(0.5 * (low + high)), np.log(0.01)
    return u


def gap() -> tuple[np.ndarray, float, float]:
    """The ends (m) of the widest jump, and the frictions at its ends."""
    curve = model().nodes.predicted_at(np.zeros(len(model().layout.slots))).curve
    width = np.where(curve.jumps[0], np.abs(np.diff(curve.x[0])), 0.0)
    j = int(np.argmax(width))
    assert width[j] > 100.0
    return curve.x[0, j : j + 2], float(MU[j]), float(MU[j + 1])


def within(x: np.ndarray) -> np.ndarray:
    (far, near), _, _ = gap()
    return (x > near + 1e-6) & (x < far - 1e-6)


def test_looked_up_stops_are_the_twins() -> None:
    tables = model().nodes.predicted_at(coordinates())
    _, low, _ = gap()
    mu = np.random.default_rng(0).uniform(low - 4 * MU_STEP, low + 5 * MU_STEP, (2, 300))
    record, x, elevation, left = look_up(tables, mu)
    for k in range(2):
        one = [naive_stop(tables.curve[k], m) for m in mu[k]]
        np.testing.assert_allclose(x[k], [s[0] for s in one], atol=1e-9)
        np.testing.assert_allclose(elevation[k], [s[1] for s in one], atol=1e-9)
    np.testing.assert_array_equal(record[0], x[0])
    np.testing.assert_array_equal(record[1], elevation[1])
    assert not left.any()


@pytest.mark.parametrize("kind", ["compare", "hazard"])
def test_no_draw_stops_within_a_jump(kind: str) -> None:
    posterior, u = model(), coordinates()
    fitted = fitted_model(posterior, np.repeat(u[None], 10, 0), {})
    rng = np.random.default_rng(2)
    (far, near), _, _ = gap()
    if kind == "compare":
        x = predict_stops(fitted, N, rng).x
    else:
        path = path_hazard(fitted, records(), "T", None, [1e4], seed=0)
        found = volume_bounds(path, 1e4, N, rng)
        x = np.array(
            [
                found.runout_x_m.q05,
                found.runout_x_m.q50,
                found.runout_x_m.q95,
                *found.runout_x_steps_m,
            ],
            dtype=float,
        )
    # Draws lie on both sides.
    assert np.any(x >= far - 1e-6)
    assert np.any(x <= near + 1e-6)
    assert not within(x).any()


def test_a_look_up_takes_little_beside_what_it_finds(monkeypatch: pytest.MonkeyPatch) -> None:
    tables = model().nodes.predicted_at(coordinates())
    row = np.arange(600) % 2
    many = replace(
        tables, **{name: getattr(tables, name)[row] for name in ("record", "x", "elevation")}
    )
    many = replace(many, status=tables.status[row])
    _, low, _ = gap()
    mu = np.random.default_rng(0).uniform(low - 4 * MU_STEP, low + 5 * MU_STEP, (600, 1000))
    whole = look_up(many, mu)
    monkeypatch.setattr(stops, "NUMBERS_AT_ONCE", 20_000)
    tracemalloc.start()
    found = look_up(many, mu)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    for one, other in zip(found, whole, strict=True):
        np.testing.assert_array_equal(one, other)
    assert peak < 1.3 * sum(part.nbytes for part in found)


@pytest.mark.parametrize("distribution", ["lognormal", "normal"])
def test_predicted_friction_of_two_kinds_is_a_mixture(distribution: str) -> None:
    given = posterior(observations(speeds=False), "two-kinds", distribution=distribution)
    kinds = next(e for e in given.effects if e.key == "two-kinds")
    share, shift = 0.3, -0.5
    own = np.array([share, shift]) / [p.prior_sd for p in kinds.parameters]
    names = ("two-kinds.share", "two-kinds.shift")
    u = near(given, **dict(zip(names, own.tolist(), strict=True)))
    found = predict_stops(fitted_model(given, np.repeat(u[None], 5, 0), {}), N, RNG(3))
    rng, layout, volumes = RNG(4), given.layout, given.observations.volumes
    scatter = np.exp(u[layout.scatter])
    for i in (0, 4):
        expected = []
        for _ in range(N):
            log_volume = volumes.mean[i] + volumes.sd[i] * rng.standard_normal()
            log_mu = u[0] - u[1] * np.exp(log_volume) * 1e-6
            log_mu += (1.0 - share) * shift if rng.random() < share else -share * shift
            off = scatter * rng.standard_normal()
            expected.append(np.exp(log_mu + off) if layout.log_scatter else np.exp(log_mu) + off)
        assert stats.ks_2samp(found.friction[i], expected).pvalue > 0.01


def _model(n: float, *effects: str, **settings: str) -> FittedModel:
    given = posterior(observations(speeds=False), *effects, **settings)
    first = given.layout.law.coordinates
    u = np.array([near(given, 0.0, k, **{"n in 1e-6/m3": n}) for k in range(400)])
    u[:, 0] += 0.02 * np.random.default_rng(0).standard_normal(400)
    assert first[0] == "log a"
    return fitted_model(given, u, {"P0": np.full(400, 0.1)})


def _largest(model: FittedModel, path_id: str | None = None) -> float:
    columns = model.observations.columns
    known = np.exp(columns.log_volume)
    if path_id is not None:
        known = known[columns.path_index == columns.paths.index(path_id)]
    return float(np.nanmax(known))


def test_within_the_records_nothing_is_said() -> None:
    model = _model(1.0)
    assert extrapolation(model, "P1", _largest(model, "P1")) == []


def test_how_far_beyond_the_path_and_all_paths() -> None:
    model = _model(0.01)
    path = min(model.observations.columns.paths, key=lambda p: _largest(model, p))
    largest, all_paths = _largest(model, path), _largest(model)
    (note,) = extrapolation(model, path, 0.5 * (largest + all_paths), path)
    assert note.values["times_path"] == pytest.approx(0.5 * (1.0 + all_paths / largest), rel=0.05)
    assert note.startswith(f"{path}: ")
    assert "all paths" not in note
    assert "and 3 times that of all paths" in extrapolation(model, path, 3.0 * all_paths)[0]
    factors = (3.0, "3"), (136.0, "140"), (1.002, "1.01"), (1.032, "1.03"), (1.36, "1.4")
    for times, told in factors:
        found = extrapolation(model, "elsewhere", times * all_paths)[0]
        assert found.key == "beyond_all"
        assert f"is {told} times the largest recorded" in found


@pytest.mark.parametrize(("n", "side"), [(1.0, "under 0.1"), (-1.0, "over 1.5")])
def test_friction_that_no_avalanche_has_is_loud(n: float, side: str) -> None:
    found = extrapolation(_model(n), "P0", 5e7)
    assert found[-1].values["share"] == pytest.approx(1.0)
    assert side in found[-1]
    assert "OUT OF BOUNDS" in found[-1]


def test_the_bounded_law_stays_within() -> None:
    given = posterior(observations(speeds=False), law="asymptotic")
    u = np.array([near(given) for _ in range(400)])
    model = fitted_model(given, u, {})
    drawn = drawn_frictions(model, "P0", 1e9)
    assert drawn.min() >= 0.1
    assert drawn.max() <= 1.5
    assert np.median(drawn) == pytest.approx(np.exp(-0.8 - 0.5), rel=0.03)
    assert len(extrapolation(model, "P0", 1e9)) == 1


def test_draws_have_the_scatter_and_the_offset_of_the_path() -> None:
    """The share under the limit is that of the normal of log friction."""
    model = _model(0.0, "path-effect")
    u = model.draws.copy()
    u[:, model.posterior.layout.scatter] = np.log(0.6)
    wide = fitted_model(model.posterior, np.repeat(u, 50, axis=0), {"P0": np.full(20000, 0.1)})
    drawn = drawn_frictions(wide, "P0", 1e4)
    assert np.median(drawn) == pytest.approx(np.exp(-0.7), rel=0.02)
    from scipy.stats import norm  # noqa: PLC0415

    expected = norm.cdf((np.log(0.1) + 0.7) / np.hypot(0.6, 0.02))
    assert np.mean(drawn < 0.1) == pytest.approx(expected, abs=0.003)
