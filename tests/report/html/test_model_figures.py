"""The posterior's histograms, and the normals over them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from avahazard.report.html.model_figures import posterior_figures
from avahazard.results.calibration import ParameterSummary


def test_each_histogram_has_the_normal_of_its_draws() -> None:
    rng = np.random.default_rng(3)
    draws = {"a": rng.normal(0.5, 0.02, 4000), "still": np.ones(4000)}
    summary = ParameterSummary(mean=0.5, sd=0.02, mode=0.5, q05=0.467, q95=0.533, unit="")
    (figure,) = posterior_figures(dict.fromkeys(draws, summary), draws)
    bars, line = figure.data
    x, y = np.asarray(line["x"]), np.asarray(line["y"])
    np.testing.assert_allclose(y, norm.pdf(x, draws["a"].mean(), draws["a"].std()))
    # Bars and line are on one scale: they hold the same area, and these draws are normal.
    area = float(np.sum(bars["y"]) * bars["width"])
    assert area == pytest.approx(1.0)
    assert np.trapezoid(y, x) == pytest.approx(1.0, abs=0.01)
    assert np.max(np.abs(np.interp(bars["x"], x, y) - bars["y"])) < 0.15 * y.max()
