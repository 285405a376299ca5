"""What each event would have left as its record."""

from __future__ import annotations

import gc
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from avahazard.effects.effect import FrontEffect, MotionEffect, Parameter, ShiftEffect
from avahazard.effects.site import KEPT_TERRAINS
from avahazard.inference.likelihood.predicted import Predicted, predict_records, resistance_of
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.prediction import look_up
from avahazard.physics.block import LEFT_PROFILE, STOPPED, run
from avahazard.physics.cells import build_cells
from avahazard.physics.ground_spline import GroundPosterior
from avahazard.physics.resistance import no_resistance
from avahazard.physics.runout_curve import MU
from avahazard.physics.smooth_profile import KEPT
from avahazard.physics.speed import speeds_along
from avahazard.physics.terrain import Terrain
from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.path import Path, Profile

X = np.linspace(0.0, 1900.0, 96)


@cache
def study() -> Observations:
    return build_observations(
        Records(
            (Path("P"), Path("Q")),
            tuple(
                Profile(n, X, top - 0.8 * X + 2e-4 * X**2) for n, top in (("P", 1e3), ("Q", 2e3))
            ),
            (
                Event("x", "P", runout_x_m=1200.0),
                Event("y", "Q", runout_elevation_m=1300.0, release_elevation_m=1900.0),
                Event("straight", fall_height_m=500.0, runout_length_m=1000.0),
                Event("left", "Q", left_profile=True),
            ),
            (Speed("y", 20.0, 2.0, x_m=700.0), Speed("y", 25.0, 2.0, x_m=400.0)),
        )
    )


E = (Parameter("", "m", 0.0, 0.0, 1.0),)


@cache
def base() -> Predicted:
    """What the block without effects leaves."""
    return predict_records(study(), (), {})


def _alone(event: int):
    """The stops of one event's block, run by itself."""
    site = study().sites[study().columns.path_index[event]]
    start = site.terrain.node(site.release_x[study().release[event]])
    stops = run(build_cells(site.terrain, no_resistance(site.terrain)), np.array([start]), MU)
    return site, stops.x[0], stops.y[0], stops.status[0]


@pytest.mark.parametrize("event", [0, 1, 3])
def test_records_stand_in_the_coordinate_of_each_event(event: int) -> None:
    site, x, y, status = _alone(event)
    left = status == LEFT_PROFILE
    assert 20 < left.sum() < len(MU) - 100
    record = x if event == 0 else y
    end = site.smooth.x_max if event == 0 else site.terrain.y[-1]
    assert np.array_equal(base().record[event], np.where(left, end, record))
    assert np.array_equal(base().x[event], np.where(left, site.smooth.x_max, x))
    assert np.array_equal(base().elevation[event], np.where(left, site.terrain.y[-1], y))
    assert np.array_equal(base().status[event], status)


def test_without_a_profile_the_record_is_that_of_the_energy_line() -> None:
    assert np.array_equal(base().record[2], 500.0 / MU)
    assert np.isnan(base().elevation[2]).all()
    assert np.all(base().status[2] == STOPPED)


def test_speeds_at_the_places_where_they_were_measured() -> None:
    site = study().sites[1]
    cells = build_cells(site.terrain, no_resistance(site.terrain))
    start = site.terrain.node(site.release_x[study().release[1]])
    (speeds,) = base().speeds
    assert speeds.shape == (len(MU), 2)
    assert np.array_equal(speeds, speeds_along(cells, start, MU, np.array([400.0, 700.0])))


def _on_a_hump(stop_x: float, left: bool = False) -> Observations:
    """A path with a hump half-way down, which a block either passes or stops before."""
    y = 1000.0 - 0.55 * X + 1e-4 * X**2 + 60.0 * np.exp(-(((X - 900.0) / 120.0) ** 2))
    place = {"left_profile": True} if left else {"runout_x_m": stop_x}
    return build_observations(
        Records(
            (Path("P"),),
            (Profile("P", X, y),),
            (Event("e", "P", **place),),  # type: ignore[arg-type]
            (Speed("e", 20.0, 2.0, x_m=300.0), Speed("e", 15.0, 2.0, x_m=700.0)),
        )
    )


def test_where_f_jumps_over_the_stop_u2_is_that_of_the_mean_friction() -> None:
    given = _on_a_hump(1000.0)
    found = predict_records(given, (), {})
    (jumped,) = found.jumped
    assert found.curve[0].broken[jumped.cell]
    assert found.x[0, jumped.cell] > 1000.0 > found.x[0, jumped.cell + 1]
    site = given.sites[0]
    resistance = no_resistance(site.terrain)
    release = float(site.release_x[0])
    expected = site.squares_to_rest(
        site.cells(resistance), release, 1000.0, np.array([300.0, 700.0])
    )
    np.testing.assert_array_equal(jumped.square, expected)
    # More friction than that of the block which passes.
    assert np.all(jumped.square < found.speeds[0][jumped.cell] ** 2)


def test_a_stop_of_a_block_and_one_that_left_jump_nothing() -> None:
    curve = predict_records(_on_a_hump(1000.0), (), {}).curve[0]
    k = np.flatnonzero(~curve.broken)[1]
    somewhere = float(np.mean(curve.x[k : k + 2]))
    for given in (_on_a_hump(somewhere), _on_a_hump(0.0, left=True)):
        (jumped,) = predict_records(given, (), {}).jumped
        assert jumped.cell == -1


def test_a_shift_moves_recorded_elevations_only() -> None:
    effect = ShiftEffect(
        "e", E, lambda _columns, values: np.array([values[0], values[0], 0.0, 0.0])
    )
    moved = predict_records(study(), (effect,), {"e": np.array([17.0])})
    assert np.array_equal(moved.record[0], base().record[0])
    assert moved.record[1] == pytest.approx(base().record[1] + 17.0)
    assert np.array_equal(moved.record[2:], base().record[2:])


@pytest.mark.parametrize("metres", [40.0, -40.0])
def test_the_front_is_ahead_along_the_path(metres: float) -> None:
    effect = FrontEffect("e", E, lambda columns, values: np.full(len(columns), values[0]))
    moved = predict_records(study(), (effect,), {"e": np.array([metres])})
    site = study().sites[0]
    inside = (
        (moved.status[0] == STOPPED) & (base().status[0] == STOPPED) & (base().record[0] > 50.0)
    )
    assert inside.sum() > 50
    for j in np.flatnonzero(inside)[::7]:
        a, b = sorted([base().record[0, j], moved.record[0, j]])
        x = np.linspace(a, b, 400)
        length = np.sum(np.hypot(np.diff(x), np.diff(site.smooth.height(x))))
        assert length == pytest.approx(abs(metres), abs=0.05)
        assert np.sign(moved.record[0, j] - base().record[0, j]) == np.sign(metres)
    height = site.smooth.height(moved.record[0, inside])
    assert moved.elevation[0, inside] == pytest.approx(height)


def test_a_front_past_the_end_has_left_where_the_block_has_not() -> None:
    effect = FrontEffect("e", E, lambda columns, values: np.full(len(columns), values[0]))
    moved = predict_records(study(), (effect,), {"e": np.array([200.0])})
    newly = (moved.status[0] == LEFT_PROFILE) & (base().status[0] == STOPPED)
    assert newly.sum() > 3
    assert np.all(moved.record[0, newly] == 1900.0)
    assert np.all(base().record[0, newly] > 1900.0 - 200.0)


def _drag(_site, resistance, values):
    return replace(resistance, drag=resistance.drag + values[0])


def test_a_neutral_effect_is_the_base_model_bit_for_bit() -> None:
    effect = MotionEffect("e", E, _drag)
    neutral = predict_records(study(), (effect,), {"e": np.array([0.0])})
    assert np.array_equal(neutral.record, base().record)
    strong = predict_records(study(), (effect,), {"e": np.array([1e-3])})
    stopped = (base().status[0] == STOPPED) & (MU < 0.7)
    assert np.all(strong.record[0, stopped] < base().record[0, stopped])


def test_an_effect_of_speed_runs_over_fine_cells() -> None:
    site = study().sites[0]
    effect = MotionEffect("e", E, _drag, speed_dependent=True)
    active = resistance_of(site, (effect,), {"e": np.array([1e-3])}, 1.0)
    assert len(active.drag) == site.fine_terrain.n_cells
    neutral = resistance_of(site, (effect,), {"e": np.array([0.0])}, 1.0)
    assert len(neutral.drag) == site.terrain.n_cells


def test_without_curvature_the_block_is_on_the_energy_line() -> None:
    flat = predict_records(study(), (), {}, curvature=0.0)
    site = study().sites[0]
    top = float(site.smooth.height(site.release_x[0]))
    stopped = (flat.status[0] == STOPPED) & (flat.record[0] > 10.0)
    mu = (top - flat.elevation[0, stopped]) / (flat.record[0, stopped] - site.release_x[0])
    assert mu == pytest.approx(MU[stopped], abs=1e-6)


def test_without_any_profile_all_is_as_beside_one() -> None:
    """There no table of places is made: one number stands for all of them."""
    events = tuple(
        Event(f"e{i}", fall_height_m=h, runout_length_m=2.5 * h)
        for i, h in enumerate((150.0, 731.7, 2000.0))
    )
    path, profile = Path("P"), Profile("P", X, 1e3 - 0.8 * X + 2e-4 * X**2)
    stop = Event("x", "P", runout_x_m=1200.0)
    alone = predict_records(build_observations(Records(events=events)), (), {})
    mixed = build_observations(Records((path,), (profile,), (*events, stop)))
    beside = predict_records(mixed, (), {})
    for name in ("record", "x", "elevation", "status", "sigma"):
        np.testing.assert_array_equal(getattr(alone, name), getattr(beside, name)[:3])
    assert alone.x.strides == alone.status.strides == (0, 0)
    mu = np.array([[-0.1, 0.0, 0.0005, 0.019, 0.3, 1.2, 2.5]] * 3)
    for found, other in zip(
        look_up(alone, mu), look_up(beside, np.vstack([mu, mu[:1]])), strict=True
    ):
        np.testing.assert_array_equal(found, other[:3])


def test_of_many_paths_the_ground_is_let_go_once_their_tables_are_made() -> None:
    n = 6 * KEPT_TERRAINS
    names = [f"P{k}" for k in range(n)]
    records = Records(
        tuple(Path(name) for name in names),
        tuple(Profile(name, X, 1e3 + k - 0.8 * X + 2e-4 * X**2) for k, name in enumerate(names)),
        tuple(Event(name, name, runout_x_m=1200.0) for name in names),
    )
    before = _alive()
    observations = build_observations(records)
    predicted = predict_records(observations, (), {})
    assert len(observations.sites) == n
    assert predicted.record.shape == (n, len(MU))
    of_ground, of_error = _alive() - before
    # Cells of a terrain keep some of it for themselves.
    assert of_ground <= 2 * KEPT_TERRAINS
    assert of_error <= KEPT


def _alive() -> np.ndarray:
    """Terrains, and errors of grounds, that are held."""
    gc.collect()
    held = gc.get_objects()
    return np.array([sum(type(it) is kind for it in held) for kind in (Terrain, GroundPosterior)])
