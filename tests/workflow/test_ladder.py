"""The ladder of models."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store.results import COMPARISON, latest_result
from avahazard.store.session import reading
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import stored_comparison
from avahazard.workflow.ladder import ladder, standing
from avahazard.workflow.requests import CalibrateRequest

pytestmark = pytest.mark.usefixtures("drawn_little")


def test_models_never_compared_are_compared_on_the_way(snow_database: str, tmp_path: Path) -> None:
    calibrate(snow_database, "mh", CalibrateRequest(method="metropolis", chains=2, draws=200))
    picture = tmp_path / "ladder.svg"
    found = ladder(snow_database, plot=picture)
    base, metropolis = found.rows
    with reading(snow_database) as session:
        compared = stored_comparison(latest_result(session, COMPARISON, "base"))
    assert compared is not None
    expected = standing(compared)
    for key in ("rmse_m", "crps_m", "held_out_crps_m", "elpd_loo", "elpd_loo_se", "coverage_90"):
        assert getattr(base, key) == getattr(expected, key)
    assert base.speed_rmse_m_s is None
    assert metropolis.rmse_m is None
    assert ["mh is not compared" in note for note in found.notes].count(True) == 1
    # Each model has its own, and all together are those of the ladder.
    assert (*base.notes, *metropolis.notes) == found.notes
    assert "mh is not compared" in metropolis.notes[-1]
    assert "<svg" in picture.read_text(encoding="utf-8")


def test_no_model(database: str, tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="There is no model yet"):
        ladder(database)
    with pytest.raises(AvahazardError, match="not the name of a picture"):
        ladder(database, plot=tmp_path / "a.txt")
