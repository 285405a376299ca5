"""The picture of zones."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avahazard.physics.smooth_profile import smooth_profile
from avahazard.report.zones_figure import DrawnZones, draw_zones
from tests.cli.zone_entries import entry


def test_a_panel_for_each_path_and_one_legend(tmp_path: Path) -> None:
    x = np.linspace(0.0, 900.0, 50)
    path = DrawnZones("Path (made up)", smooth_profile(x, 2000.0 - 0.5 * x), entry())
    draw_zones(tmp_path / "zones.svg", "Zones", [path, path, path])
    text = (tmp_path / "zones.svg").read_text()
    assert text.count("<!-- Path (made up) -->") == 3
    for label in ("red zone", "end of blue, 5 to 95 %", "pressure, T = 300 years, extrapolated"):
        assert text.count(f"<!-- {label}") == 1
