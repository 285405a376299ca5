"""The picture of the ladder."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from avahazard.report.ladder_figure import draw_ladder
from avahazard.results.base import Rows
from avahazard.results.comparison import BudgetPart
from avahazard.results.ladder import Rung
from tests.results.samples import COMPARISON, RUNG


def test_models_and_floor(tmp_path: Path) -> None:
    def row(model: str, parent: str | None, crps: float | None) -> Rung:
        added = ("season",) if parent else ()
        return replace(RUNG, model=model, parent=parent, added=added, held_out_crps_m=crps)

    file = tmp_path / "a.svg"
    draw_ladder(
        file,
        [
            row("base", None, 90.0),
            row("child", "base", 70.0),
            row("mh", None, None),
            row("worse", "child", 77.0),
        ],
    )
    text = file.read_text(encoding="utf-8")
    for word in ("base", "child", "+ season", "70 m", "−20 m (−22%)", "77 m", "+7 m (+10%)"):
        assert f"<!-- {word} -->" in text
    assert "errors of the data alone: 8 m" in text
    assert "<!-- mh -->" not in text


def test_models_that_have_no_floor(tmp_path: Path) -> None:
    file = tmp_path / "a.svg"
    draw_ladder(file, [replace(RUNG, parent="gone", noise_floor_crps_m=None)])
    assert "floor" not in file.read_text(encoding="utf-8")


def test_the_budgets_are_stacked_bars_below(tmp_path: Path) -> None:
    parts = {"record": 8.0, "scatter": 40.0, "season": 30.0, "unexplained": 20.0}
    budget = Rows(BudgetPart(source, rms) for source, rms in parts.items())
    file = tmp_path / "a.svg"
    draw_ladder(file, [RUNG], {"base": replace(COMPARISON, budget=budget)})
    text = file.read_text(encoding="utf-8")
    for words in ("natural scatter", "explained by season", "unexplained", "40 m", "30 m", "20 m"):
        assert f"<!-- {words} -->" in text
    assert "<!-- 8 m -->" not in text  # too short for a figure
