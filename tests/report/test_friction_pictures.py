"""Pictures of friction, and those of the paper: what they are made of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.report.friction_pictures import (
    ModelLaw,
    draw_densities,
    draw_model_laws,
    draw_posterior,
    draw_residuals,
    draw_with_normals,
    normal_density,
)
from avahazard.report.html.content import FrictionView
from avahazard.results.friction import FrictionDensity

RNG = np.random.default_rng(3)


def text_of(file: Path) -> str:
    """The drawing, whose words are comments of matplotlib's SVG."""
    return file.read_text(encoding="utf-8")


def test_a_normal_is_one() -> None:
    x = np.linspace(-3.0, 5.0, 4001)
    density = normal_density(x, 1.0, 0.5)
    assert np.trapezoid(density, x) == pytest.approx(1.0)
    assert np.trapezoid(density * (x - 1.0) ** 2, x) == pytest.approx(0.25)


def test_every_parameter_has_the_normal_of_its_draws(tmp_path: Path) -> None:
    draws = {"a": RNG.normal(0.5, 0.01, 900), "n": RNG.normal(3e-7, 8e-8, 900), "fixed": np.ones(9)}
    draw_posterior(tmp_path / "a.svg", "first", draws, {"n": "1/m3"})
    drawn = text_of(tmp_path / "a.svg")
    a, n = draws["a"], draws["n"]
    assert f"normal: {a.mean():.4f} ± {a.std(ddof=1):.2g}".rstrip("0") in drawn
    assert f"± {n.std(ddof=1):.2g}" in drawn
    assert "correlation" in drawn
    assert "fixed" not in drawn


def test_densities_have_normals_and_the_band_of_moved_records(tmp_path: Path) -> None:
    x = np.linspace(0.2, 0.8, 61)
    density = FrictionDensity(
        "all", 40, 5.0, tuple(x), tuple(np.exp(-x)), tuple(x > 0.7), 0.5, 0.05
    )
    mu = {"all": RNG.normal(0.5, 0.05, 40)}
    band = {"all": np.stack([0.9 * np.exp(-x), 1.1 * np.exp(-x)])}
    draw_with_normals(tmp_path / "a.svg", "Friction", [density], mu, band)
    drawn = text_of(tmp_path / "a.svg")
    assert "records move" in drawn
    assert f"normal: {round(float(mu['all'].mean()), 3):.6g} ±" in drawn


def test_models_with_the_same_events_show_them_once(tmp_path: Path) -> None:
    volume = np.geomspace(1e3, 1e5, 30)
    law = np.full((3, 30), 0.5)
    scatter = np.stack([law[0] * f for f in (0.8, 0.9, 1.1, 1.2)])
    points = 0.5 + 0.02 * RNG.standard_normal(30)
    laws = [
        ModelLaw("one", FrictionView(volume, law, scatter), volume, points),
        ModelLaw("two", FrictionView(volume, 0.9 * law, None), volume, points),
        ModelLaw("other", FrictionView(volume, 1.1 * law, None), volume, points + 0.1),
    ]
    draw_model_laws(tmp_path / "a.svg", laws)
    drawn = text_of(tmp_path / "a.svg")
    assert "one: 30 events" in drawn
    assert "two: 30 events" not in drawn
    assert "other: 30 events" in drawn
    assert "two: law, median" in drawn
    assert "two: 90 % of avalanches" not in drawn


def test_residuals_have_their_normal_and_the_models(tmp_path: Path) -> None:
    off = RNG.normal(0.0, 1.0, 50)
    x = np.linspace(-5.0, 5.0, 101)
    draw_residuals(tmp_path / "a.svg", "m", off, (x, normal_density(x, 0.0, 1.0)), "log μ")
    drawn = text_of(tmp_path / "a.svg")
    assert "their normal" in drawn
    assert "scatter of the model" in drawn
    assert "50 events" in drawn


def test_each_density_is_a_line_dashed_beyond_the_records(tmp_path: Path) -> None:
    mu = np.linspace(0.2, 0.8, 61)
    curve = (tuple(mu), tuple(np.exp(-mu)), tuple(mu > 0.6))
    draw_densities(
        tmp_path / "a.svg",
        [FrictionDensity(name, 9, 5.0, *curve, 0.5, 0.1) for name in ("all", "B")],
    )
    drawn = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert drawn.count("stroke-dasharray") == 2
