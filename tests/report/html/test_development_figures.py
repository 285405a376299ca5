"""The bars of the ladder in the report."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from avahazard.report.html.development_figures import ladder_figure
from avahazard.report.html.figure import BLUE
from avahazard.report.language import ENGLISH
from tests.results.samples import CALIBRATION, NOT_COMPARED, RUNG


def content(*errors: float | None) -> Any:
    """A report of model `m1` on a ladder with these held-out errors."""
    ladder = [
        replace(NOT_COMPARED if e is None else RUNG, model=f"m{k}", held_out_crps_m=e)
        for k, e in enumerate(errors)
    ]
    return SimpleNamespace(language=ENGLISH, ladder=ladder, model=replace(CALIBRATION, model="m1"))


def test_bars_are_the_errors_of_compared_models_and_this_one_is_blue() -> None:
    figure = ladder_figure(content(50.0, 40.0, None))
    assert figure is not None
    (bars,) = figure.data
    assert bars["x"] == [50.0, 40.0]
    assert [color == BLUE for color in bars["marker"]["color"]] == [False, True]
    assert figure.layout["shapes"][0]["x0"] == 8.0
    assert "1 model" in figure.caption


def test_nothing_compared_is_no_figure() -> None:
    assert ladder_figure(content(None, None)) is None
