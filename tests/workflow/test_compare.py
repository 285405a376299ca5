"""Comparison of a model with its measurements."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.scoring.change import standing
from avahazard.inference.model.observations import build_observations
from avahazard.records.errors import AvahazardError
from avahazard.results.comparison import Comparison
from avahazard.store.results import COMPARISON, latest_result
from avahazard.store.session import reading
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare, coordinate_name, ladder
from avahazard.workflow.database import import_files
from avahazard.workflow.next_step import latest_comparison
from avahazard.workflow.requests import CalibrateRequest
from tests.criticism.studies import slopes, straight, with_left
from tests.few_draws import few_draws


@pytest.fixture(scope="module")
def document(snow_world: Path, tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    file = tmp_path_factory.mktemp("compare") / "copy.db"
    file.write_bytes((snow_world / "base.db").read_bytes())
    with few_draws():
        return compare(str(file), "base")


def test_what_it_holds(document: Comparison) -> None:
    scores = document.scores
    assert document.model == "base"
    assert Comparison.from_dict(document.to_dict()) == document
    assert scores.speed is None
    assert document.held_out.by == "path"
    assert document.held_out.runout.n == scores.runout.n == 120
    assert document.measured_force is None


def test_it_points_at_snow(document: Comparison) -> None:
    worst = document.where_it_fails[0]
    assert worst.axis == "snow_type"
    assert worst.p_value < 0.01
    p_values = [row.p_value for row in document.where_it_fails]
    assert p_values == sorted(p_values)


def test_scores_make_sense(document: Comparison) -> None:
    scores, held = document.scores, document.held_out
    assert scores.runout.noise_floor_m < scores.runout.rmse_m
    assert scores.runout.crps_m < scores.runout.rmse_m
    assert abs(scores.runout.coverage_90 - 0.9) < 0.08
    assert held.elpd_loo < scores.elpd_loo + 3.0
    assert abs(held.runout.crps_m / scores.runout.crps_m - 1.0) < 0.15


@pytest.mark.usefixtures("drawn_little")
def test_it_is_stored_and_the_same_again(snow_database: str, document: Comparison) -> None:
    with reading(snow_database) as session:
        assert latest_result(session, COMPARISON, "base") is None
    again = compare(snow_database, "base")
    assert again == document
    with reading(snow_database) as session:
        stored = latest_result(session, COMPARISON, "base")
    assert stored is not None
    assert stored["scores"]["elpd_loo"] == document.scores.elpd_loo


def test_records_that_changed_since(snow_database: str, write: Any) -> None:
    import_files(
        snow_database, [write("events.csv", "event_id,fall_height_m,runout_length_m\nx,800,1500\n")]
    )
    with pytest.raises(AvahazardError, match="have changed"):
        compare(snow_database, "base")


@pytest.mark.usefixtures("drawn_little")
def test_the_papers_methods(snow_database: str) -> None:
    calibrate(snow_database, "gibbs", CalibrateRequest(method="gibbs", chains=2, draws=300))
    calibrate(snow_database, "mh", CalibrateRequest(method="metropolis", chains=2, draws=300))
    found = compare(snow_database, "gibbs")
    scores, held_out = found.scores, found.held_out
    assert np.isfinite(scores.elpd_loo)
    assert abs(scores.runout.coverage_90 - 0.9) < 0.1
    # Fits without a part take volumes as exact, as the method does.
    assert held_out.runout.crps_m < 1.2 * scores.runout.crps_m
    assert abs(held_out.elpd_loo - scores.elpd_loo) < 0.05 * abs(scores.elpd_loo)
    with pytest.raises(AvahazardError, match="metropolis"):
        compare(snow_database, "mh")


def test_the_coordinate_of_the_records() -> None:
    assert coordinate_name(build_observations(straight(5))) == "length"
    assert coordinate_name(build_observations(slopes())) == "elevation"
    assert coordinate_name(build_observations(with_left(slopes(kind="x")))) == "x"


pytestmark = pytest.mark.usefixtures("drawn_little")


def test_models_never_compared_are_compared_on_the_way(snow_database: str, tmp_path: Path) -> None:
    calibrate(snow_database, "mh", CalibrateRequest(method="metropolis", chains=2, draws=200))
    picture = tmp_path / "ladder.svg"
    found = ladder(snow_database, plot=picture)
    base, metropolis = found.rows
    with reading(snow_database) as session:
        compared = latest_comparison(session, "base")
    assert compared is not None
    expected = standing(compared)
    for key in ("rmse_m", "crps_m", "held_out_crps_m", "elpd_loo", "elpd_loo_se", "coverage_90"):
        assert getattr(base, key) == getattr(expected, key)
    assert base.speed_rmse_m_s is None
    assert metropolis.rmse_m is None
    assert ["mh is not compared" in note for note in found.notes].count(True) == 1
    # Each model has its own; those of the ladder are on the best, and on what is not compared.
    assert (*base.notes, metropolis.notes[-1]) == found.notes
    assert "mh is not compared" in metropolis.notes[-1]
    assert "<svg" in picture.read_text(encoding="utf-8")


def test_no_model(database: str, tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="There is no model yet"):
        ladder(database)
    with pytest.raises(AvahazardError, match="not the name of a picture"):
        ladder(database, plot=tmp_path / "a.txt")
