"""`avahazard hazard`."""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest
from typer.testing import Result

from avahazard.cli.hazard import show_windows
from avahazard.notes import Note
from tests.telling import untold

Run = Callable[..., Result]
KEYS = {
    *("path_id", "return_period_years", "volume_m3", "runout_x_m", "runout_elevation_m"),
    *("interval", "p_left_profile", "n_draws"),
}


def test_the_document(on_my_models: Run) -> None:
    words = ("hazard", "base", "-T", "100", "-V", "20000", "--path", "scey", "--draws", "2000")
    rows = json.loads(on_my_models("--json", *words).stdout)
    assert [row["return_period_years"] for row in rows] == [100.0, None]
    for row in rows:
        assert row.keys() >= KEYS
        assert row["runout_x_m"].keys() == {"mean", "q05", "q50", "q95"}
        assert row["n_draws"] == 2000


def test_people_see_bounds_volumes_and_what_varies(on_my_models: Run) -> None:
    done = on_my_models("--verbose", "hazard", "base", "-T", "100", "-T", "10000")
    assert done.exit_code == 0
    words = " ".join(done.stdout.split())
    assert "5–95 %" in words
    assert "saint-clement 100" in words
    assert untold(words, "beyond:", "lognormal", "observed_from", "observed_to") == []
    # The next step can be copied: it stands on one line.
    lines = [line for line in done.stdout.splitlines() if not line.startswith("  avahazard")]
    assert max(map(len, lines)) <= 80
    assert untold(done.stderr, "extrapolation") == []


def test_one_line_says_that_years_are_those_of_the_data_set() -> None:
    winters = Note("of_winters")
    notes = [
        Note("data_window", f"P{k}", seasons=winters, first=2006, last=2022) for k in range(1, 7)
    ]
    (line,) = show_windows([Note("no_rate"), *notes, *notes])
    assert isinstance(line, str)
    assert line.startswith(
        "P1, P2, P3 and 3 more: the rate of avalanches counts the path's records"
    )
    assert "winters from 2006 to 2022" in line


def test_normal_friction_reports_what_cannot_be(on_my_models: Run) -> None:
    made = on_my_models(
        *("calibrate", "n", "--distribution", "normal", "--draws", "60", "--chains", "2"),
        *("--path", "scey"),
    )
    assert made.exit_code == 0
    done = on_my_models("--json", "hazard", "n", "-V", "60000000", "--path", "scey")
    (row,) = json.loads(done.stdout)
    assert row["n_nonpositive_friction"] > 0
    assert untold(done.stderr, "draws of friction", "0") == []


@pytest.mark.parametrize(
    ("words", "status", "message"),
    [
        (("nobody",), 1, "There is no model nobody"),
        (("base", "--path", "everest"), 1, "There is no path 'everest'"),
        (
            ("base", "-T", "-5"),
            2,
            "The return period is -5. It must be a number of years over 1, up to 1000000.",
        ),
        (
            ("base", "-V", "2e4", "-V", "-3"),
            2,
            "The volume is -3. It must be a number of m3 over 0, up to 1e+15.",
        ),
        (("base", "-T", "2"), 1, "no volume returns every 2 years"),
        (("base", "-V", "much"), 2, "--volume"),
        ((), 2, "NAME"),
    ],
)
def test_what_cannot_be_done(
    on_my_models: Run, words: tuple[str, ...], status: int, message: str
) -> None:
    done = on_my_models("hazard", *words)
    assert (done.exit_code, done.stdout) == (status, "")
    assert message in done.stderr
