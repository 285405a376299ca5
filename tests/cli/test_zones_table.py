"""Tables of zones."""

from __future__ import annotations

from io import StringIO
from typing import Any

from rich.console import Console

from avahazard.cli.zones_table import show_zones


def entry(beyond: bool = False) -> dict[str, Any]:
    zone = {"color": "#000000", "from_x_m": 100.0, "to_x_q05_m": 700.0}
    places = [
        {
            "x_m": 100.0 + 10.0 * i,
            "elevation_m": 2000.0 - 5.0 * i,
            "p_reach_per_year": 0.0123,
            "by_return_period": [
                {
                    "return_period_years": period,
                    "speed_m_s": {"q05": 10.0 + i, "q50": 20.0 + i, "q95": 30.0 + i},
                    "pressure_kpa": {"q05": 30.0, "q50": 120.0, "q95": 270.0},
                }
                for period in (30.0, 300.0)
            ],
        }
        for i in range(81)
    ]
    return {
        "path_id": "P01",
        "limits": "swiss",
        "density_kg_m3": {"mean": 300.0, "sd": 50.0},
        "interval": "what a year exceeds",
        "places": places,
        "zones": [
            {**zone, "zone": "red", "to_x_m": 100.0, "to_x_q95_m": 200.0, "beyond": False},
            {**zone, "zone": "blue", "to_x_m": 900.0, "to_x_q95_m": None, "beyond": beyond},
        ],
    }


def shown(entries: list[dict[str, Any]]) -> str:
    console = Console(file=StringIO(), width=80)
    show_zones(console, entries)
    file = console.file
    assert isinstance(file, StringIO)
    assert max(map(len, file.getvalue().splitlines())) <= 80
    return " ".join(file.getvalue().split())


def test_one_path_place_by_place() -> None:
    text = shown([entry()])
    assert "P01 red none – 700–200" in text
    assert "P01 blue 100 900 700–beyond" in text
    assert "P01: speed u in m/s and pressure p in kPa exceeded in T years" in text
    assert "x m z m p/year u 30 p 30 u 300 p 300" in text
    assert "900 1600 0.012 100 120 100 120" in text


def test_many_paths_by_their_largest() -> None:
    text = shown([entry(), entry(beyond=True)])
    assert "P01 blue 100 beyond 700–beyond" in text
    assert "P01 300 100 90–110 120 30–270" in text
    assert "beyond: past the end of the profile" in text
