"""What a path needs, built once."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.effects.site import Site
from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.path_hazard import PathHazard, path_hazard
from avahazard.hazard.path_rows import path_rows
from avahazard.hazard.scenario import Scenario
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.physics.cells import Cells
from avahazard.physics.runout_curve import RunoutCurve
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from tests.hazard.parabola import LAW, TOP_M, observations

DRAG = definition("turbulent-drag").build({})
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
    draws = np.column_stack([*columns, drag / DRAG.parameters[0].prior_sd])
    specification = Specification(scatter="volume" if scatter == "volume" else "constant")
    return FittedModel(Posterior(observations(), specification, (DRAG,)), draws, {})


def records() -> Records:
    x = np.arange(0.0, 3601.0, 30.0)
    y = 2500.0 - 0.9 * x + 1.2e-4 * x**2
    path = Path("p", release_elevation_m=TOP_M)
    events = tuple(Event(f"e{k}", path_id="p", volume_m3=1e5) for k in range(3))
    return Records((path,), (Profile("p", x, y),), events)


def build(fitted: FittedModel, volumes: EventVolumes | None = VOLUMES) -> PathHazard:
    return path_hazard(
        *(fitted, records(), "p", volumes, [2e4, 5e4]),
        event_columns=False,
        volume_matters=True,
        seed=0,
    )


@pytest.mark.parametrize("scatter", ["constant", "volume"])
def test_friction_is_that_of_the_posterior_draw_by_draw(scatter: str) -> None:
    fitted = model(scatter)
    path = build(fitted)
    events = (Event("a", path_id="p", volume_m3=2e4), Event("b", path_id="p", volume_m3=5e4))
    there = Records(records().paths, records().profiles, events)
    posterior = fitted.on(build_observations(there, fitted.observations)).posterior
    for u, k in zip(path.draws.u[::60], range(0, 300, 60), strict=True):
        location, sigma = posterior.location_and_scatter(u, np.array([[2e4], [5e4]]))
        for i, here in enumerate(path.at_volume.values()):
            assert here.location[k, 0] == pytest.approx(location[i, 0], rel=1e-13)
            assert here.scatter[k, 0] == pytest.approx(sigma[i, 0], rel=1e-13)


def test_each_draw_has_the_tables_of_drag_like_its_own() -> None:
    path = build(model())
    scale = DRAG.parameters[0].prior_sd
    tables = np.array([values["turbulent-drag"][0] for values in path.avalanches.values])
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
    assert len(runs) == len(set(runs)) == len(path.avalanches.tables)


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
