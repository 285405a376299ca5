"""Pictures of paths."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.records.errors import AvahazardError
from avahazard.report.html.content import PathView, path_view
from avahazard.report.path_pictures import draw_path, draw_paths
from avahazard.results.hazard import Spread
from avahazard.results.terrain import TerrainRunout
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


X = np.arange(0.0, 3001.0, 50.0)
RECORDS = Records(
    (Path("P01", name="Path (made up)"),),
    (Profile("P01", X, 2000.0 - 0.8 * X + 1e-4 * X**2),),
    tuple(Event(str(x), path_id="P01", runout_x_m=x) for x in (1200.0, 1500.0)),
)
BASELINE = TerrainRunout(
    path_id="P01", coefficients="norway", source="a paper", status="found", release_x_m=0.0,
    beta_deg=20.0, beta_x_m=1500.0, alpha_deg=18.0, alpha_sd_deg=2.0, runout_x_m=1600.0,
    runout_elevation_m=900.0, runout_x_low_m=1500.0, runout_x_high_m=None, notes=(),
)  # fmt: skip


def row_of(q95: float | None = 2000.0) -> PathView:
    spread = Spread(None if q95 is None else 1550.0, 1200.0, 1500.0, q95)
    return path_view(RECORDS, "P01", rows=[replace(HAZARD_ROW, runout_x_m=spread, volume_m3=2e4)])


@pytest.mark.parametrize("n", [1, 3])
def test_the_figure_of_the_report_for_each_path(tmp_path: FilePath, n: int) -> None:
    file = tmp_path / "bounds.svg"
    draw_paths(file, "Bounds", [row_of(), row_of(None), row_of()][:n])
    text = file.read_text()
    assert text.count("<!-- elevation (m) -->") == n
    assert text.count("<!-- recorded stops -->") == n
    assert text.count("<!-- avalanches of 20\u202f000 m³ -->") == n
    assert text.count("<!-- Path (made up) -->") == n


def test_the_design_runout_and_the_baseline_are_there(tmp_path: FilePath) -> None:
    row = replace(HAZARD_ROW, return_period_years=100.0, design=DESIGN_RUNOUT)
    view = path_view(RECORDS, "P01", rows=[row], alpha_beta=[BASELINE])
    draw_paths(tmp_path / "a.svg", None, [view])
    text = (tmp_path / "a.svg").read_text()
    for words in ("design runout, 100 years", "α-β, Norway"):
        assert f"<!-- {words} -->" in text


def test_a_dollar_in_a_name_is_no_formula(tmp_path: FilePath) -> None:
    named = replace(RECORDS, paths=(replace(RECORDS.paths[0], name="$1_000^^$"),))
    draw_paths(tmp_path / "a.svg", None, [path_view(named, "P01")])
    assert "$1_000^^$" in (tmp_path / "a.svg").read_text()


def test_zones_have_their_speeds_below(tmp_path: FilePath) -> None:
    view = path_view(RECORDS, "P01", zones=entry())
    draw_paths(tmp_path / "a.svg", "Zones", [view], drag=False)
    text = (tmp_path / "a.svg").read_text()
    for words in ("zone: blue", "speed without drag (m/s)"):
        assert f"<!-- {words} -->" in text


def test_no_name_of_a_picture(tmp_path: FilePath) -> None:
    with pytest.raises(AvahazardError, match="not the name of a picture"):
        draw_paths(tmp_path / "bounds.txt", "Bounds", [row_of()])
