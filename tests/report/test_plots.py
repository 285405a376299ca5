"""Pictures of paths, of friction, and those of the paper: what they are made of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest
from scipy.stats import norm

from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.records.errors import AvahazardError
from avahazard.report.figure_pictures import draw_figures
from avahazard.report.html.content import PathView, path_view
from avahazard.report.html.model_figures import density_figure, normal_line, posterior_figures
from avahazard.report.plots import draw_path, draw_paths, draw_residuals
from avahazard.results.calibration import ParameterSummary
from avahazard.results.friction import FrictionDensity
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


RNG = np.random.default_rng(3)


def text_of(file: FilePath) -> str:
    """The drawing, whose words are comments of matplotlib's SVG."""
    return file.read_text(encoding="utf-8")


def test_a_normal_is_one() -> None:
    x, density = normal_line(1.0, 0.5)
    assert density == pytest.approx(norm.pdf(x, 1.0, 0.5))
    assert (x[0], x[-1]) == (-1.0, 3.0)


def test_every_parameter_has_the_normal_of_its_draws(tmp_path: FilePath) -> None:
    draws = {"a": RNG.normal(0.5, 0.01, 900), "n": RNG.normal(3e-7, 8e-8, 900), "fixed": np.ones(9)}
    known = {
        name: ParameterSummary(v.mean(), v.std(), v.mean(), *np.quantile(v, (0.05, 0.95)), unit)
        for (name, v), unit in zip(draws.items(), ("", "1/m3", ""), strict=True)
    }
    draw_figures(tmp_path / "a.svg", "first", posterior_figures(known, draws), columns=3)
    drawn = text_of(tmp_path / "a.svg")
    assert f"mean {draws['a'].mean():.4g}; 90 % between" in drawn
    assert "1/m³" in drawn
    assert "correlation" in drawn
    assert "fixed" not in drawn


def test_residuals_have_their_normal_and_the_models(tmp_path: FilePath) -> None:
    off = RNG.normal(0.0, 1.0, 50)
    draw_residuals(tmp_path / "a.svg", "m", off, normal_line(0.0, 1.0), "log μ")
    drawn = text_of(tmp_path / "a.svg")
    assert "their normal" in drawn
    assert "scatter of the model" in drawn
    assert "50 events" in drawn


def test_each_density_is_a_line_dashed_beyond_the_records(tmp_path: FilePath) -> None:
    mu = np.linspace(0.2, 0.8, 61)
    curve = (tuple(mu), tuple(np.exp(-mu)), tuple(mu > 0.6))
    both = [FrictionDensity(name, 9, 5.0, *curve, 0.5, 0.0) for name in ("all", "B")]
    draw_figures(tmp_path / "a.svg", None, [density_figure(both, {})])
    drawn = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert "<!-- all events (9) -->" in drawn
    # In the curve of a path, in its legend, and in the tails of both.
    assert drawn.count("stroke-dasharray") == 4
