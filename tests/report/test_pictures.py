"""Results that are drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import avahazard.report.pictures  # noqa: F401 (how results are drawn)
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Rows
from avahazard.results.ladder import Ladder
from tests.results.samples import (
    CALIBRATION,
    CANDIDATE,
    COMPARISON,
    DIAGNOSIS,
    FRICTIONS,
    RUNG,
)

DRAWN = [
    (COMPARISON, "volume: above 80 000 m3 (9)"),
    (DIAGNOSIS, "base is adequate"),
    (Ladder(Rows([RUNG])), "42 m"),
    (FRICTIONS, "all (3)"),
]


@pytest.mark.parametrize(("result", "word"), DRAWN, ids=lambda value: type(value).__name__)
def test_a_result_draws_itself(tmp_path: Path, result: Any, word: str) -> None:
    file = result.plot(tmp_path / "a.svg")
    assert f"<!-- {word} -->" in file.read_text(encoding="utf-8")
    assert word in result.plot()._repr_svg_()


@pytest.mark.parametrize("result", [CALIBRATION, CANDIDATE])
def test_others_say_that_they_have_no_picture(result: Any) -> None:
    with pytest.raises(AvahazardError, match="no picture") as error:
        result.plot()
    assert "Comparison, Diagnosis, Frictions, Ladder" in error.value.hint
