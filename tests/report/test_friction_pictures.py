"""The picture of densities."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avahazard.report.friction_pictures import draw_densities
from avahazard.results.friction import FrictionDensity


def test_each_density_is_a_line_dashed_beyond_the_records(tmp_path: Path) -> None:
    mu = np.linspace(0.2, 0.8, 61)
    curve = (tuple(mu), tuple(np.exp(-mu)), tuple(mu > 0.6))
    draw_densities(
        tmp_path / "a.svg",
        [FrictionDensity(name, 9, 5.0, *curve, 0.5, 0.1) for name in ("all", "B")],
    )
    drawn = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert drawn.count("stroke-dasharray") == 2
