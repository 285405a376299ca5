"""Pictures of friction, and those of the paper: what they are made of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from avahazard.report.figure_pictures import draw_figures
from avahazard.report.friction_pictures import draw_residuals
from avahazard.report.html.model_figures import density_figure, normal_line, posterior_figures
from avahazard.results.calibration import ParameterSummary
from avahazard.results.friction import FrictionDensity

RNG = np.random.default_rng(3)


def text_of(file: Path) -> str:
    """The drawing, whose words are comments of matplotlib's SVG."""
    return file.read_text(encoding="utf-8")


def test_a_normal_is_one() -> None:
    x, density = normal_line(1.0, 0.5)
    assert density == pytest.approx(norm.pdf(x, 1.0, 0.5))
    assert (x[0], x[-1]) == (-1.0, 3.0)


def test_every_parameter_has_the_normal_of_its_draws(tmp_path: Path) -> None:
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


def test_residuals_have_their_normal_and_the_models(tmp_path: Path) -> None:
    off = RNG.normal(0.0, 1.0, 50)
    draw_residuals(tmp_path / "a.svg", "m", off, normal_line(0.0, 1.0), "log μ")
    drawn = text_of(tmp_path / "a.svg")
    assert "their normal" in drawn
    assert "scatter of the model" in drawn
    assert "50 events" in drawn


def test_each_density_is_a_line_dashed_beyond_the_records(tmp_path: Path) -> None:
    mu = np.linspace(0.2, 0.8, 61)
    curve = (tuple(mu), tuple(np.exp(-mu)), tuple(mu > 0.6))
    both = [FrictionDensity(name, 9, 5.0, *curve, 0.5, 0.0) for name in ("all", "B")]
    draw_figures(tmp_path / "a.svg", None, [density_figure(both, {})])
    drawn = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert "<!-- all events (9) -->" in drawn
    # In the curve of a path, in its legend, and in the tails of both.
    assert drawn.count("stroke-dasharray") == 4
