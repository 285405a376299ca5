"""What each event would have left as its record, and the runs of the block that say so."""

from __future__ import annotations

import gc
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from avahazard.effects.effect import FrontEffect, MotionEffect, Parameter, ShiftEffect
from avahazard.effects.site import KEPT_TERRAINS
from avahazard.inference.likelihood import predicted
from avahazard.inference.likelihood.predicted import (
    FAR,
    KEPT_ASKED,
    KEPT_RUNS,
    KeptRuns,
    Predicted,
    _within,
    keep,
    predict_records,
    resistance_of,
    stops_asked,
)
from avahazard.inference.model.observations import LEFT, LENGTH, Observations, build_observations
from avahazard.inference.prediction import look_up
from avahazard.physics.block import LEFT_PROFILE, STOPPED, run
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.runout_curve import MU
from avahazard.physics.smooth_profile import KEPT, GroundPosterior
from avahazard.physics.speed import speeds_along, squares_to_rest
from avahazard.physics.terrain import Terrain, node_of
from avahazard.records.collection import Event, Path, Profile, Records, Speed
from tests.inference.studies import observations, posterior

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
    speeds = base().speeds[0].speed
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
    (block,) = found.speeds
    assert found.curve[0].discontinuous[block.cell]
    assert found.x[0, block.cell] > 1000.0 > found.x[0, block.cell + 1]
    site = given.sites[0]
    resistance = no_resistance(site.terrain)
    release = float(site.release_x[0])
    cells, places = site.cells(resistance), np.array([300.0, 700.0])
    expected = squares_to_rest(cells, node_of(cells.x, release), 1000.0, places)
    np.testing.assert_array_equal(block.at_jump, expected)
    # More friction than that of the block which passes.
    assert np.all(block.at_jump < block.speed[block.cell] ** 2)


def test_a_stop_of_a_block_and_one_that_left_jump_nothing() -> None:
    curve = predict_records(_on_a_hump(1000.0), (), {}).curve[0]
    k = np.flatnonzero(~curve.discontinuous)[1]
    somewhere = float(np.mean(curve.x[k : k + 2]))
    for given in (_on_a_hump(somewhere), _on_a_hump(0.0, left=True)):
        (block,) = predict_records(given, (), {}).speeds
        assert block.cell == -1


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


@pytest.mark.parametrize(
    ("size", "most"), [(0, 64), (1_000_000, 64), (2_000_000, 32), (40_000_000, 2), (10**12, 2)]
)
def test_fewer_are_kept_where_they_are_large(size: int, most: int) -> None:
    kept: dict[int, str] = {}
    for k in range(70):
        keep(kept, k, "", 64, size)
    assert list(kept) == list(range(70))[-most:]


VALUES = {"leading-edge": np.array([0.8]), "epoch-bias": np.array([15.0, 1950.0])}


@pytest.mark.parametrize("effects", [(), ("leading-edge",)])
def test_every_stop_within_reach_of_a_record_is_asked_for(effects: tuple[str, ...]) -> None:
    given = observations()
    model = posterior(given, *effects)
    values = {key: VALUES[key] for key in effects}
    table = predict_records(given, model.effects, values)
    # The block's own stops: what its front comes to is another thing.
    block = predict_records(given, (), {})
    asked = stops_asked(given, model.effects, values)
    tracks = {track.event for track in given.speeds}
    for i in np.flatnonzero(given.kind != LENGTH):
        one = asked[given.columns.path_index[i]]
        low, high = one.low[given.release[i]], one.high[given.release[i]]
        left = table.status[i] == 1
        if given.kind[i] == LEFT:
            assert low <= np.min(block.x[i][left]) <= high
            assert np.isinf(high) == (i in tracks)
            continue
        z = (table.record[i] - given.observed[i]) / table.sigma[i]
        near = ~left & (np.abs(z) < FAR)
        assert near.any()
        assert low <= np.min(block.x[i][near])
        assert high >= np.max(block.x[i][near])


def test_little_else_is_asked_for() -> None:
    given = observations()
    asked = stops_asked(given, (), {})
    length = given.sites[0].smooth.x_max - given.sites[0].smooth.x_min
    assert np.median(asked[0].high - asked[0].low) < 0.5 * length


def test_what_left_asks_for_the_end_of_its_path_alone() -> None:
    given = observations(36, 6, False)
    i = int(np.flatnonzero(given.kind == LEFT)[0])
    k, site = given.columns.path_index[i], given.sites[given.columns.path_index[i]]
    alone = replace(given, kind=np.where(given.columns.path_index == k, LEFT, given.kind))
    one = stops_asked(alone, (), {})[k]
    length = site.smooth.x_max - site.smooth.x_min
    assert one.low[given.release[i]] > site.smooth.x_max - 0.01 * length
    assert one.high[given.release[i]] == pytest.approx(site.smooth.x_max)


def test_places_between_which_a_record_lies_are_near_it_however_small_its_error() -> None:
    z = np.array(
        [
            [-100.0, -50.0, 40.0, 90.0],  # between two places
            [-100.0, -7.0, 40.0, 7.0],  # there and back
            [100.0, 60.0, 20.0, np.nan],  # near none: the nearest
        ]
    )
    first, last = _within(z)
    assert first.tolist() == [1, 0, 2]
    assert last.tolist() == [2, 3, 2]


def test_a_record_that_no_stop_is_near_asks_for_the_nearest() -> None:
    given = observations(12, 6, False)
    i = int(np.flatnonzero(given.kind == 0)[0])
    observed = given.observed.copy()
    observed[i] += 5000.0
    one = stops_asked(replace(given, observed=observed), (), {})[given.columns.path_index[i]]
    # Higher than all the path: its top.
    assert one.low[given.release[i]] <= given.sites[0].smooth.x_min + 20.0


@pytest.mark.parametrize("near", [False, True])
def test_sites_are_run_in_groups_as_if_all_at_once(
    monkeypatch: pytest.MonkeyPatch, near: bool
) -> None:
    given = observations()
    asked = stops_asked(given, (), {}) if near else None
    together = predicted.run_blocks(given, (), {}, 1.0, asked)
    monkeypatch.setattr(predicted, "SITES_AT_ONCE", 2)
    apart = predicted.run_blocks(given, (), {}, 1.0, asked)
    assert len(given.sites) > 2
    assert len(apart.tables) == len(together.tables) == len(given.sites)
    for one, other in zip(apart.tables, together.tables, strict=True):
        np.testing.assert_array_equal(one.x, other.x)


def test_no_more_is_kept_than_there_is_room_for() -> None:
    model = posterior(observations(36, 6, False), "turbulent-drag", "epoch-bias")
    runs = KeptRuns(model.observations, model.effects, 1.0, in_sight=True)
    for k in range(KEPT_RUNS + 10):
        drag = np.array([1e-5 * k])
        runs.records({"turbulent-drag": drag, "epoch-bias": np.array([0.0, 1950.0])})
    for k in range(KEPT_ASKED + 10):
        raised = np.array([float(k), 1950.0])
        runs.near_records({"turbulent-drag": drag, "epoch-bias": raised})
    assert len(runs._runs) <= KEPT_RUNS
    assert len(runs._asked) <= KEPT_ASKED
    runs.forget()
    assert not runs._runs


def test_runs_are_kept_by_what_moves_the_block() -> None:
    model = posterior(observations(36, 6, False), "turbulent-drag", "epoch-bias")
    runs = KeptRuns(model.observations, model.effects, 1.0, in_sight=True)
    for drag, raised in ((1e-3, 0.0), (1e-3, 20.0), (2e-3, 20.0)):
        told = {"turbulent-drag": np.array([drag]), "epoch-bias": np.array([raised, 1950.0])}
        np.testing.assert_array_equal(runs.records(told).record, runs.fresh_records(told).record)
    assert len(runs._runs) == 2
