"""The picture of the α-β runouts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from avahazard.hazard.alpha_beta import REGRESSIONS, alpha_beta
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.report.alpha_beta_figure import AlphaBetaPath, draw_alpha_beta
from avahazard.results.hazard import HazardRow, Spread
from tests.results.samples import HAZARD_ROW

ROW = replace(
    HAZARD_ROW,
    runout_x_m=Spread(None, 1500.0, 1700.0, None),
    return_period_years=100.0,
    volume_m3=1e4,
)


def drawn(length: float, row: HazardRow | None = None) -> AlphaBetaPath:
    x = np.linspace(0.0, length, 80)
    smooth = smooth_profile(x, 2000.0 - x + 2.5e-4 * x**2)
    found = tuple(alpha_beta(smooth, 0.0, regression) for regression in REGRESSIONS)
    return AlphaBetaPath("Path (made up)", smooth, found, np.array([1500.0]), row)


def test_a_panel_for_each_path_and_one_legend_of_all(tmp_path: Path) -> None:
    file = tmp_path / "picture.svg"
    # The first has no β-point, on the second the lines run past the end.
    draw_alpha_beta(file, [drawn(1500.0), drawn(1900.0), drawn(2300.0, ROW)])
    text = file.read_text()
    assert text.count("<!-- Path (made up) -->") == 3
    assert text.count("<!-- no β-point -->") == 1
    for label in (
        "α-β, norway: α ± 1 sd",
        "model, avalanches of the volume V: 5 to 95 %",
        "recorded stops",
    ):
        assert text.count(f"<!-- {label} -->") == 1
