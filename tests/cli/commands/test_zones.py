"""`avahazard zones`."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import Result

from avahazard.cli.hazard import show_zones
from avahazard.cli.output import CliSettings, show
from avahazard.results.base import Rows
from avahazard.results.hazard import Zones
from tests.report.zone_entries import entry
from tests.telling import untold

Run = Callable[..., Result]
KEYS = {
    *("zone", "color", "from_x_m", "to_x_m", "to_x_q05_m", "to_x_q95_m", "beyond"),
    "extrapolated",
}


def test_the_document(on_my_models: Run, tmp_path: Path) -> None:
    words = (
        "zones",
        "base",
        "--no-drag",
        "-T",
        "100",
        "--path",
        "scey",
        "--plot",
        str(tmp_path / "z.png"),
    )
    (entry,) = json.loads(on_my_models("--json", *words).stdout)
    assert entry.keys() >= {"path_id", "limits", "places", "zones", "notes"}
    place = entry["places"][10]
    assert place.keys() >= {"x_m", "elevation_m", "p_reach_per_year", "by_return_period"}
    found = place["by_return_period"]
    assert [one["return_period_years"] for one in found] == [30.0, 100.0, 300.0]
    assert found[0]["speed_m_s"].keys() == {"q05", "q50", "q95"}
    assert found[0]["pressure_kpa"].keys() == {"q05", "q50", "q95"}
    assert [zone["zone"] for zone in entry["zones"]] == ["red", "blue"]
    assert entry["zones"][0].keys() == KEYS
    assert (tmp_path / "z.png").read_bytes()[:4] == b"\x89PNG"


def test_people_see_zones_and_largest_speeds(on_my_models: Run, tmp_path: Path) -> None:
    file = tmp_path / "volumes.csv"
    rows = [f"{p},{t},{200 * t}" for p in ("scey", "gurraz") for t in (10, 100)]
    file.write_text("\n".join(["path_id,return_period_years,volume_m3", *rows, ""]))
    paths = ("--path", "scey", "--path", "gurraz")
    done = on_my_models(
        "zones", "base", "--no-drag", "--limits", "french", *paths, "--volumes", str(file)
    )
    assert done.exit_code == 0
    assert untold(done.stderr, "scey", 300, "extrapolation", "powder") == []
    words = " ".join(done.stdout.split())
    assert untold(words, "french", "5–95 %", "300 ± 50 kg/m³") == []
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_of_many_paths_only_zones_are_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    def paths(n: int) -> Zones:
        return Zones(Rows(replace(entry(), path_id=f"P{k}") for k in range(n)), ())

    console = Console(width=80)
    with console.capture() as brief:
        show(console, show_zones(paths(25)))
    with monkeypatch.context() as asked, console.capture() as whole:
        asked.setattr("avahazard.cli.hazard.settings", lambda: CliSettings(verbose=True))
        show(console, show_zones(paths(25)))
    assert len(brief.get().splitlines()) <= 80
    assert "Largest speed" not in brief.get()
    assert "the same with avahazard --verbose" in brief.get()
    assert untold(whole.get(), "Design runout", "Largest speed") == []
    with console.capture() as few:
        show(console, show_zones(paths(3)))
    assert untold(few.get(), "Design runout", "Largest speed") == []


@pytest.mark.parametrize(
    ("words", "status", "message"),
    [
        (("nobody",), 1, "There is no model nobody"),
        (("base", "--limits", "none.toml"), 1, "There are no limits 'none.toml'"),
        (("base", "--density", "-3"), 2, "The density is -3"),
        (
            ("base", "-T", "0.5"),
            2,
            "The return period is 0.5. It must be a number of years over 1, up to 1000000.",
        ),
        (("base", "--threshold", "5000"), 2, "--threshold is for --frequency gpd"),
        ((), 2, "name"),
    ],
)
def test_what_cannot_be_done(
    on_my_models: Run, words: tuple[str, ...], status: int, message: str
) -> None:
    done = on_my_models("zones", *words)
    assert (done.exit_code, done.stdout) == (status, "")
    assert message.lower() in done.stderr.lower()
