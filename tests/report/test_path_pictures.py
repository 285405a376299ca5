"""The picture of a path."""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np

from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.path import Path, Profile
from avahazard.report.path_pictures import DrawnZones, draw_path, draw_zones
from tests.report.zone_entries import entry


def test_marks_are_drawn_where_there_are_any(tmp_path: FilePath) -> None:
    x = np.linspace(0.0, 1000.0, 11)
    profile = Profile("B", x, 800.0 - 0.5 * x)
    smooth = smooth_profile(profile.x_m, profile.y_m)
    drawn = []
    for name, stops in (("none.svg", np.empty(0)), ("some.svg", np.array([700.0, 900.0]))):
        draw_path(tmp_path / name, Path("B"), profile, smooth, np.array([0.0]), stops)
        drawn.append((tmp_path / name).read_text(encoding="utf-8"))
    # Two marks on the path and one in the legend, in red.
    assert [text.count("stroke: #d62728") for text in drawn] == [0, 4]


def test_a_panel_for_each_path_and_one_legend(tmp_path: FilePath) -> None:
    x = np.linspace(0.0, 900.0, 50)
    path = DrawnZones("Path (made up)", smooth_profile(x, 2000.0 - 0.5 * x), entry())
    draw_zones(tmp_path / "zones.svg", "Zones", [path, path, path])
    text = (tmp_path / "zones.svg").read_text()
    assert text.count("<!-- Path (made up) -->") == 3
    for label in ("red zone", "end of blue, 5 to 95 %", "pressure, T = 300 years, extrapolated"):
        assert text.count(f"<!-- {label}") == 1
