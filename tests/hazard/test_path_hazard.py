"""What a path needs, built once."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.effects.site import Site
from avahazard.hazard.extremes import EventVolumes
from avahazard.hazard.path_hazard import (
    PathHazard,
    RecordedStops,
    friction_of_volumes,
    limits_of_sight,
    path_hazard,
    rising_friction,
)
from avahazard.hazard.rows import Scenario
from avahazard.inference.fitted_model import FittedModel, fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_model import FrictionModel, friction_model
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.physics.cells import Cells
from avahazard.physics.runout_curve import RunoutCurve
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.results.hazard import MapPoint
from tests.hazard.parabola import LAW, TOP_M, draws, future, observations, path_rows

DRAG = definition("turbulent-drag").build({})
RELEASES = (TOP_M, 2350.0)
VOLUMES = EventVolumes(np.full(50, 0.3), np.log([1e4, 1e5]), np.full((50, 2), 0.5))


def model(scatter: str = "constant") -> FittedModel:
    """300 draws with drag, and friction that falls where drag rises."""
    rng = np.random.default_rng(1)
    drag = rng.uniform(0.0, 0.003, 300)
    columns = [
        np.log(0.7) - 120.0 * drag,
        np.full(300, LAW[1]),
        np.log(rng.uniform(0.05, 0.2, 300)),
    ]
    if scatter == "volume":
        columns.append(rng.normal(0.0, 1.0, 300))
    u = np.column_stack([*columns, drag / DRAG.parameters[0].prior_sd])
    specification = Specification(scatter="volume" if scatter == "volume" else "constant")
    return fitted_model(Posterior(observations(), specification, (DRAG,)), u, {})


def records() -> Records:
    x = np.arange(0.0, 3601.0, 30.0)
    y = 2500.0 - 0.9 * x + 1.2e-4 * x**2
    path = Path("p", release_elevation_m=TOP_M)
    events = tuple(Event(f"e{k}", path_id="p", volume_m3=1e5) for k in range(3))
    return Records((path,), (Profile("p", x, y),), events)


def build(fitted: FittedModel, volumes: EventVolumes | None = VOLUMES) -> PathHazard:
    return path_hazard(fitted, records(), "p", volumes, [2e4, 5e4], seed=0)


@pytest.mark.parametrize("scatter", ["constant", "volume"])
def test_friction_is_that_of_the_posterior_draw_by_draw(scatter: str) -> None:
    fitted = model(scatter)
    path = build(fitted)
    events = (Event("a", path_id="p", volume_m3=2e4), Event("b", path_id="p", volume_m3=5e4))
    there = Records(records().paths, records().profiles, events)
    posterior = fitted.on(build_observations(there, fitted.observations)).posterior
    for u, k in zip(path.draws.u[::60], range(0, 300, 60), strict=True):
        location, sigma = posterior.friction.location_and_scatter(u, np.array([[2e4], [5e4]]))
        for i, here in enumerate(path.at_volume.values()):
            assert here.location[k, 0] == pytest.approx(location[i, 0], rel=1e-13)
            assert here.scatter[k, 0] == pytest.approx(sigma[i, 0], rel=1e-13)


def test_each_draw_has_the_tables_of_drag_like_its_own() -> None:
    path = build(model())
    scale = DRAG.parameters[0].prior_sd
    tables = np.array([resistance.drag[0] for resistance in path.avalanches.resistances])
    assert len(tables) == 32
    own = path.draws.u[:, 3] * scale
    # 300 draws over 0.003: a group spans about 1e-4.
    assert np.abs(tables[path.draws.group] - own).max() < 2e-4
    # The few draws of the mixture take the same tables.
    drag = (np.log(0.7) - path.avalanches.location[:, 0, 0] - LAW[1] * 0.01) / 120.0
    assert np.abs(tables[path.avalanches.group] - drag).max() < 2e-4
    assert (np.diff(path.draws.group) >= 0).all()


def test_the_block_is_run_once_for_each_group(monkeypatch: pytest.MonkeyPatch) -> None:
    fitted, table, runs = model(), Site.table, []

    def count(site: Site, cells: Cells) -> RunoutCurve:
        runs.append(float(cells.drag[0]))
        return table(site, cells)

    monkeypatch.setattr(Site, "table", count)
    path = build(fitted)
    path_rows(path, [Scenario("p", 2e4), Scenario("p", 5e4)], 1000, seed=0)
    assert len(runs) == len(set(runs)) == len(path.avalanches.curves)


def test_another_process_finds_the_same() -> None:
    path = build(model())
    scenarios = [Scenario("p", 2e4)]
    other: PathHazard = pickle.loads(pickle.dumps(path))
    assert path_rows(other, scenarios, 2000, seed=1) == path_rows(path, scenarios, 2000, seed=1)


def test_a_model_travels_to_another_process() -> None:
    fitted = model()
    other: FittedModel = pickle.loads(pickle.dumps(fitted))
    assert build(other).draws.u.tolist() == build(fitted).draws.u.tolist()


def test_nothing_known_of_the_rate_means_no_chances() -> None:
    path = build(model(), None)
    rows = path_rows(path, [Scenario("p", 2e4), Scenario("p", 5e4)], 1000, seed=0)
    assert all(row.reach is None and row.design is None for row in rows)
    assert path_rows(build(model()), [Scenario("p", 2e4)], 1000, seed=0)[0].reach is not None


def law_alone() -> FrictionModel:
    return friction_model(Specification(), (), speeds=False)


def test_every_class_has_the_friction_of_every_volume() -> None:
    u = draws(0.1, 3)
    u[:, 0] += [0.0, 0.1, 0.3]
    volume = np.array([1e4, 5e4, 2e5])
    location, scatter = friction_of_volumes(law_alone(), future(RELEASES), u, volume)
    assert location.shape == scatter.shape == (3, 2, 3)
    expected = u[:, 0, None] - 1e-6 * u[:, 1, None] * volume
    for k in range(2):
        np.testing.assert_allclose(location[:, k], expected)
    np.testing.assert_allclose(scatter, 0.1)


def test_friction_rises_in_the_draws_whose_law_does() -> None:
    u = draws(0.1, 4)
    u[:, 1] = [2.0, 1.0, -1.0, 3.0]
    found = rising_friction(law_alone(), future(RELEASES), u, np.log([np.nan, 3e4, 1e4, 2e5]))
    assert found is not None
    assert found.values == {"share": 0.25, "smallest": 1e4, "largest": 2e5}


@pytest.mark.parametrize("volumes", [[np.nan, np.nan], [1e4, 1e4, np.nan]])
def test_volumes_that_are_alike_tell_nothing(volumes: list[float]) -> None:
    u = draws(0.1, 2)
    assert rising_friction(law_alone(), future(RELEASES), u, np.log(volumes)) is None


def test_the_limit_is_the_path_s_or_the_effect_s() -> None:
    given, there = observations(RELEASES), future(RELEASES)
    told = replace(there.site, path=replace(there.site.path, observed_below_m=1200.0))
    plain = fitted_model(Posterior(given, Specification(), ()), draws(0.1, 2))
    found = limits_of_sight(plain, replace(there, site=told), ({}, {}))
    assert found.tolist() == [1200.0, 1200.0]
    effect = definition("observation-limit").build({"paths": {"p": {"highest_m": 900.0}}})
    limited = fitted_model(Posterior(given, Specification(), (effect,)), draws(0.1, 2, 0.0))
    values = ({effect.key: np.array([50.0])}, {effect.key: np.array([1000.0])})
    np.testing.assert_array_equal(limits_of_sight(limited, there, values), [950.0, np.nan])


def test_the_map_holds_both_ends_of_the_line_and_nothing_beyond() -> None:
    x, east, north = np.array([100.0, 900.0]), np.array([7.0, 7.8]), np.array([46.0, 46.4])
    line = Profile("P", x, -x, easting_m=east, northing_m=north, crs="C")
    stops = RecordedStops(profile=line)
    assert stops.point(100.0) == MapPoint(7.0, 46.0, "C")
    assert stops.point(900.0) == MapPoint(7.8, 46.4, "C")
    assert stops.point(np.nextafter(100.0, 0.0)) is None
    assert stops.point(np.nextafter(900.0, 1e4)) is None
    assert RecordedStops(profile=replace(line, crs=None)).point(100.0) is None


def test_without_records_or_coordinates_there_is_nothing() -> None:
    nothing = RecordedStops()
    assert len(nothing.x) == 0
    assert nothing.farthest() is None
    assert nothing.point(0.0) is None
    assert nothing.beyond(0.0) == 0
