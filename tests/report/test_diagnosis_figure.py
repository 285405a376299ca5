"""The picture of a diagnosis."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from avahazard.report.diagnosis_figure import draw_diagnosis
from avahazard.results.base import Rows
from avahazard.results.diagnosis import Candidate
from tests.results.samples import CANDIDATE, DIAGNOSIS


def candidate(effect: str, gain: float, p_value: float) -> Candidate:
    """A candidate; chance alone gains 2 nats."""
    return replace(CANDIDATE, effect=effect, screened_gain=gain, p_value=p_value)


@pytest.mark.parametrize(
    ("verdict", "missing", "title"),
    [
        ("missing-effect", ("season",), "base lacks season"),
        ("ambiguous", ("season", "cohesion"), "base lacks one of season, cohesion"),
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
        file, replace(DIAGNOSIS, verdict=verdict, missing=missing, candidates=Rows(rows))
    )
    text = file.read_text(encoding="utf-8")
    words = (title, "season", "epoch-bias", "p = 0.005", "p = 0.80", "could be chance")
    for word in (*words, "chance alone, 19 times in 20"):
        assert f"<!-- {word} -->" in text
    assert ("<!-- named -->" in text) == bool({"season", "cohesion"} & set(missing))


def test_no_candidates(tmp_path: Path) -> None:
    file = tmp_path / "a.png"
    draw_diagnosis(file, DIAGNOSIS)
    assert file.stat().st_size > 1000


def test_the_title_says_where_data_cannot_tell(tmp_path: Path) -> None:
    file = tmp_path / "a.svg"
    draw_diagnosis(file, replace(DIAGNOSIS, verdict="adequate", missing=(), detectable_share=0.9))
    assert "cannot tell whether it lacks an effect" in file.read_text(encoding="utf-8")
