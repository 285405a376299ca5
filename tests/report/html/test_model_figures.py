"""The posterior's histograms with their normals, and the bars of the ladder."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from avahazard.report.html.figure import BLUE
from avahazard.report.html.model_figures import posterior_figures
from avahazard.report.html.score_figures import ladder_figure
from avahazard.results.calibration import ParameterSummary
from avahazard.results.comparison import LadderEntry
from tests.results.samples import LADDER_ENTRY, NOT_COMPARED


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


def entries(*errors: float | None) -> list[LadderEntry]:
    """A ladder with these held-out errors; every model is a child of the first."""
    return [
        replace(
            NOT_COMPARED if e is None else LADDER_ENTRY,
            model=f"m{k}",
            parent="m0",
            held_out_crps_m=e,
        )
        for k, e in enumerate(errors)
    ]


def test_bars_are_the_errors_of_compared_models_and_this_one_is_blue() -> None:
    figure = ladder_figure(entries(50.0, 40.0, None), "m1")
    assert figure is not None
    (bars,) = figure.data
    assert bars["x"] == [50.0, 40.0]
    assert [color == BLUE for color in bars["marker"]["color"]] == [False, True]
    assert bars["text"][1] == "40 m (−20 %)"
    assert figure.layout["shapes"][0]["x0"] == 8.0


def test_nothing_compared_is_no_figure() -> None:
    assert ladder_figure(entries(None, None), "m1") is None
