"""The picture of a comparison."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from avahazard.criticism.scoring.error_budget import SOURCES, UNEXPLAINED
from avahazard.report.figure_pictures import draw_comparison, draw_diagnosis, draw_ladder
from avahazard.report.html.score_figures import SOURCE_COLORS, budget_bars, parts_in_order
from avahazard.report.language import LANGUAGES, language_of, speaking
from avahazard.report.words import part_text
from avahazard.results.base import Rows
from avahazard.results.comparison import BudgetPart, Ladder, LadderEntry
from avahazard.results.diagnosis import Candidate
from tests.results.samples import CANDIDATE, COMPARISON, DIAGNOSIS, FAILURE, FORCE, LADDER_ENTRY


@pytest.mark.parametrize(
    ("rows", "force"), [([FAILURE], None), ([FAILURE], [FORCE]), ([], [FORCE])]
)
def test_panels(tmp_path: Path, rows: list[Any], force: list[Any] | None) -> None:
    file = tmp_path / "a.svg"
    measured = None if force is None else Rows(force)
    draw_comparison(file, replace(COMPARISON, where_it_fails=Rows(rows), measured_force=measured))
    text = file.read_text(encoding="utf-8")
    assert ("volume: above 80" in text) == bool(rows)
    assert ("resisting force per mass" in text) == bool(force)


def candidate(effect: str, gain: float, p_value: float) -> Candidate:
    """A candidate; chance alone gains 2 nats."""
    return replace(CANDIDATE, effect=effect, screened_gain=gain, p_value=p_value)


@pytest.mark.parametrize(
    ("verdict", "missing", "title"),
    [
        ("missing-effect", ("season",), "base lacks an effect: season"),
        ("ambiguous", ("season", "cohesion"), "base lacks an effect; these data"),
        ("unexplained", ("covariate:wind",), "base fails along covariate:wind"),
        ("adequate", (), "base is adequate"),
    ],
)
def test_bars_band_and_verdict(
    tmp_path: Path, verdict: str, missing: tuple[str, ...], title: str
) -> None:
    file = tmp_path / "a.svg"
    rows = [
        candidate("season", 30.0, 0.005),
        candidate("cohesion", 9.0, 0.04),
        candidate("epoch-bias", 0.0, 0.8),
    ]
    draw_diagnosis(
        file,
        replace(DIAGNOSIS, pairs=Rows(), verdict=verdict, missing=missing, candidates=Rows(rows)),
    )
    text = file.read_text(encoding="utf-8")
    for word in ("season", "epoch-bias", "p &lt; 1/", "p 0.800", "chance alone"):
        assert f"<!-- {word}" in text
    assert f"<!-- {title}" in text


def test_no_candidates(tmp_path: Path) -> None:
    file = tmp_path / "a.png"
    draw_diagnosis(file, DIAGNOSIS)
    assert file.stat().st_size > 1000


def test_a_pair_stands_on_two_lines(tmp_path: Path) -> None:
    file = tmp_path / "a.svg"
    rows = Rows([candidate("interaction:wind*snow_type", 9.0, 0.005)])
    draw_diagnosis(
        file, replace(DIAGNOSIS, pairs=Rows(), verdict="adequate", missing=(), candidates=rows)
    )
    text = file.read_text(encoding="utf-8")
    assert "<!-- snow_type -->" in text
    assert "br&gt;" not in text


def test_the_title_says_where_data_cannot_tell(tmp_path: Path) -> None:
    file = tmp_path / "a.svg"
    draw_diagnosis(
        file, replace(DIAGNOSIS, pairs=Rows(), verdict="adequate", missing=(), detectable_share=0.9)
    )
    assert "these data are insufficient" in file.read_text(encoding="utf-8")


ALL = (*SOURCES, UNEXPLAINED)


def test_every_source_is_told_everywhere() -> None:
    assert set(SOURCE_COLORS) == set(ALL)
    for code in LANGUAGES:
        with speaking(language_of(code)):
            assert len({part_text(source) for source in ALL}) == len(ALL), code
    with speaking(language_of("de")):
        assert part_text("release") == "Fehler der aufgezeichneten Anrisse"


@pytest.mark.parametrize("with_release", [True, False])
def test_a_release_without_an_error_has_no_bar(with_release: bool) -> None:
    parts = [BudgetPart(s, 5.0) for s in ALL if s != "release" or with_release]
    found = budget_bars(["m"], {"m": replace(COMPARISON, budget=Rows(parts))})
    assert ("release" in parts_in_order(found)) is with_release
    assert list(parts_in_order(found))[-1] == UNEXPLAINED


def test_models_and_floor(tmp_path: Path) -> None:
    def row(model: str, parent: str | None, crps: float | None) -> LadderEntry:
        added = ("season",) if parent else ()
        return replace(LADDER_ENTRY, model=model, parent=parent, added=added, held_out_crps_m=crps)

    file = tmp_path / "a.svg"
    rows = [
        row("base", None, 90.0),
        row("child", "base", 70.0),
        row("mh", None, None),
        row("worse", "child", 77.0),
    ]
    draw_ladder(file, Ladder(Rows(rows)))
    text = file.read_text(encoding="utf-8")
    for word in ("base", "child", "90 m", "70 m (−22 %)", "77 m (+10 %)"):
        assert f"<!-- {word} -->" in text
    assert "measurement-error floor: 8 m" in text
    assert "<!-- mh -->" not in text


def test_models_that_have_no_floor(tmp_path: Path) -> None:
    file = tmp_path / "a.svg"
    row = replace(LADDER_ENTRY, parent="gone", noise_floor_crps_m=None)
    draw_ladder(file, Ladder(Rows([row])))
    assert "floor" not in file.read_text(encoding="utf-8")


def test_the_budgets_are_stacked_bars_below(tmp_path: Path) -> None:
    parts = {"record": 8.0, "scatter": 40.0, "season": 30.0, "unexplained": 20.0}
    budget = Rows(BudgetPart(source, rms) for source, rms in parts.items())
    file = tmp_path / "a.svg"
    ladder = Ladder(Rows([LADDER_ENTRY]))
    draw_ladder(file, ladder, {"base": replace(COMPARISON, budget=budget)})
    text = file.read_text(encoding="utf-8")
    for words in (
        "scatter, natural or missing in the model",
        "explained by season",
        "unexplained",
        "40 m",
        "30 m",
        "20 m",
    ):
        assert f"<!-- {words} -->" in text
    assert "<!-- 8 m -->" not in text  # too short for a figure
