"""Pictures of paths."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.hazard.alpha_beta import REGRESSIONS, alpha_beta
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Path, Profile
from avahazard.records.errors import AvahazardError
from avahazard.report.path_pictures import (
    DrawnPath,
    DrawnZones,
    draw_alpha_beta,
    draw_bounds,
    draw_path,
    draw_zones,
)
from avahazard.results.hazard import HazardRow, Spread
from tests.gis.results import DESIGN_RUNOUT
from tests.report.zone_entries import entry
from tests.results.samples import HAZARD_ROW


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


X = np.arange(0.0, 3001.0, 50.0)


def drawn(q95: float | None, volume: float | None = 2e4, n_stops: int = 3) -> DrawnPath:
    spread = Spread(None if q95 is None else 1550.0, 1200.0, 1500.0, q95)
    return DrawnPath(
        name="Path (made up)",
        smooth=smooth_profile(X, 2000.0 - 0.8 * X + 1e-4 * X**2),
        release_x=100.0,
        stop_x=np.linspace(1200.0, 1900.0, n_stops),
        n_left=1,
        row=replace(HAZARD_ROW, runout_x_m=spread, volume_m3=volume),
    )


@pytest.mark.parametrize("n", [1, 2, 3, 8])
def test_a_panel_for_each_row(tmp_path: FilePath, n: int) -> None:
    file = tmp_path / "bounds.svg"
    draw_bounds(file, "Bounds", [drawn(2000.0)] * n)
    text = file.read_text()
    assert text.count("<!-- Path (made up) -->") == n
    assert text.count("<!-- V = 20,000 m³ -->") == n
    assert text.count("<!-- avalanches of the volume V: 5 to 95 % -->") == 1


def test_beyond_the_profile_and_without_volume_or_records(tmp_path: FilePath) -> None:
    file = tmp_path / "bounds.svg"
    draw_bounds(file, "Bounds", [drawn(None), drawn(2000.0, volume=None, n_stops=0)])
    text = file.read_text()
    assert text.count("<!-- beyond -->") == 1
    assert text.count("<!-- V = ") == 1


def test_the_design_runout_leads_with_its_legend(tmp_path: FilePath) -> None:
    file = tmp_path / "bounds.svg"
    one = drawn(2000.0)
    assert one.row is not None
    row = replace(one.row, return_period_years=100.0, design=DESIGN_RUNOUT)
    draw_bounds(file, "Bounds", [replace(one, row=row)])
    text = file.read_text()
    for words in (
        "design runout, exceeded once in 100 years: 5 to 95 %",
        "design runout, exceeded once in 100 years: median",
        "avalanches of its volume V: 5 to 95 %",
        "100-year runout x = 850 m (800 to 930)",
        "1 past the median",
    ):
        assert words in text


def test_no_name_of_a_picture(tmp_path: FilePath) -> None:
    with pytest.raises(AvahazardError, match="not the name of a picture"):
        draw_bounds(tmp_path / "bounds.txt", "Bounds", [drawn(2000.0)])


ROW = replace(
    HAZARD_ROW,
    runout_x_m=Spread(None, 1500.0, 1700.0, None),
    return_period_years=100.0,
    volume_m3=1e4,
)


def drawn_of_alpha_beta_figure(length: float, row: HazardRow | None = None) -> DrawnPath:
    x = np.linspace(0.0, length, 80)
    smooth = smooth_profile(x, 2000.0 - x + 2.5e-4 * x**2)
    found = tuple(alpha_beta(smooth, 0.0, regression) for regression in REGRESSIONS)
    return DrawnPath("Path (made up)", smooth, np.array([1500.0]), row, found)


def test_a_panel_for_each_path_and_one_legend_of_all(tmp_path: FilePath) -> None:
    file = tmp_path / "picture.svg"
    # The first has no β-point, on the second the lines run past the end.
    draw_alpha_beta(
        file,
        [
            drawn_of_alpha_beta_figure(1500.0),
            drawn_of_alpha_beta_figure(1900.0),
            drawn_of_alpha_beta_figure(2300.0, ROW),
        ],
    )
    text = file.read_text()
    assert text.count("<!-- Path (made up) -->") == 3
    assert text.count("<!-- no β-point -->") == 1
    for label in (
        "α-β, norway: α ± 1 sd",
        "model, avalanches of the volume V: 5 to 95 %",
        "recorded stops",
    ):
        assert text.count(f"<!-- {label} -->") == 1
