"""One run with its speeds."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.one_path import path_site
from avahazard.workflow.runout import run_path, run_site
from tests.workflow.worlds import bowl, stop_x


def _site(length_m: float = 1900.0):
    records = bowl(length_m)
    return path_site(records.paths[0], records.profiles[0])


@pytest.mark.parametrize("mu", [0.42, 0.5, 0.6])
def test_the_stop_is_that_of_small_steps(mu: float) -> None:
    document = run_site(_site(), mu)
    assert document["status"] == "stopped"
    assert document["runout_x_m"] == pytest.approx(stop_x(mu), abs=0.05)


def test_speeds_run_from_release_to_stop() -> None:
    document = run_site(_site(), 0.45)
    x = np.array([place["x_m"] for place in document["speeds"]])
    speed = np.array([place["speed_m_s"] for place in document["speeds"]])
    assert (x[0], speed[0], speed[-1]) == (0.0, 0.0, 0.0)
    assert x[-1] == document["runout_x_m"]
    assert np.diff(x).max() == pytest.approx(np.diff(x).min())
    assert len(x) == 100
    assert np.all(speed[1:-1] > 0.0)
    assert document["speed_max_m_s"] >= speed.max()


def test_short_runs_have_a_place_every_ten_metres() -> None:
    document = run_site(_site(), 0.75)
    x = [place["x_m"] for place in document["speeds"]]
    assert 5.0 < x[1] - x[0] <= 10.0


def test_a_run_that_leaves_or_does_not_start() -> None:
    left = run_site(_site(1000.0), 0.2)
    assert (left["status"], left["runout_x_m"], left["runout_elevation_m"]) == (
        "left_profile",
        None,
        None,
    )
    assert left["speeds"][-1]["x_m"] == 1000.0
    assert left["speeds"][-1]["speed_m_s"] > 10.0
    held = run_site(_site(), 0.9)
    assert (held["status"], held["runout_x_m"]) == ("not_released", 0.0)
    assert held["speeds"] == [{"x_m": 0.0, "speed_m_s": 0.0}]


def test_from_the_database(database: str) -> None:
    with writing(database) as session:
        save_records(session, bowl())
    assert run_path(database, "B", 0.45) == {"path_id": "B", **run_site(_site(), 0.45)} | {
        "lift_off_x_m": pytest.approx(np.nan, nan_ok=True)
    }
    with pytest.raises(AvahazardError, match="friction is 0"):
        run_path(database, "B", 0.0)
