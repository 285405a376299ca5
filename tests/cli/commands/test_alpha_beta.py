"""`avahazard alpha-beta`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from typer.testing import Result

from tests.telling import untold

Run = Callable[..., Result]
KEYS = {
    *("path_id", "coefficients", "beta_deg", "beta_x_m", "alpha_deg", "alpha_sd_deg"),
    *("runout_x_m", "runout_x_low_m", "runout_x_high_m", "status"),
}


def test_the_document(document: Callable[..., Any]) -> None:
    rows = document("alpha-beta", "scey")
    assert [row["coefficients"] for row in rows] == ["norway", "austria"]
    for row in rows:
        assert row.keys() >= KEYS
        assert row["alpha_deg"] < row["beta_deg"]


def test_people_see_angles_places_and_sources(on_twin: Run) -> None:
    done = on_twin("alpha-beta")
    assert done.exit_code == 0
    assert untold(done.stdout, "Norway:", "Bakkehøi") == []
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert done.stderr.count("saugy") == 1


def test_an_unknown_path_is_named(on_twin: Run) -> None:
    done = on_twin("alpha-beta", "everest")
    assert (done.exit_code, done.stdout) == (1, "")
    assert "There is no path 'everest'" in done.stderr
