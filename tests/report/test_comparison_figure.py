"""The picture of a comparison."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avahazard.report.comparison_figure import draw_comparison

ROW = {"axis": "volume", "level": "above 80 000 m3", "n": 9, "bias_m": 63.0, "p_value": 0.002}
FORCE = {
    "event_id": "e1",
    "speed_m_s": 12.0,
    "force_m_s2": 4.0,
    "sd_m_s2": 0.5,
    "x_m": 100.0,
    "slope_deg": 30.0,
}


@pytest.mark.parametrize(("rows", "force"), [([ROW], None), ([ROW], [FORCE]), ([], [FORCE])])
def test_panels(tmp_path: Path, rows: list[Any], force: list[Any] | None) -> None:
    file = tmp_path / "a.svg"
    draw_comparison(
        file,
        {
            "model": "base",
            "coordinate": "elevation",
            "scores": {"runout": {"noise_floor_m": 12.0}},
            "where_it_fails": rows,
            "measured_force": force,
        },
    )
    text = file.read_text(encoding="utf-8")
    assert ("volume: above 80 000 m3 (9)" in text) == bool(rows)
    assert ("Coulomb friction" in text) == bool(force)
