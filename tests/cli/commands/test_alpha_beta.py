"""`avahazard alpha-beta`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
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


def test_people_see_angles_places_and_sources(on_twin: Run, tmp_path: Path) -> None:
    done = on_twin("alpha-beta", "--plot", str(tmp_path / "a.png"))
    assert done.exit_code == 0
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
    assert untold(done.stdout, "norway:", "Bakkehøi") == []
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert done.stderr.count("saugy") == 1


@pytest.mark.parametrize(
    ("words", "status", "message"),
    [
        (("everest",), 1, "There is no path 'everest'"),
        (("--model", "base"), 2, "give --plot"),
        (("--plot", "a.txt"), 1, "not the name of a picture"),
    ],
)
def test_what_cannot_be_done(
    on_twin: Run, words: tuple[str, ...], status: int, message: str
) -> None:
    done = on_twin("alpha-beta", *words)
    assert (done.exit_code, done.stdout) == (status, "")
    assert message in done.stderr
