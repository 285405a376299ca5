"""Results are those of the references (`make frozen`): three quick data sets."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.frozen import QUICK, SETS, deviations, load, outcome, references


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_results_are_those_of_the_references(name: str, shared_data: Path) -> None:
    assert shared_data.is_dir()
    assert deviations(references(load(), name), outcome(SETS[name])) == {}


def test_what_is_tolerated() -> None:
    before = {"posterior base a": [0.5, 0.01], "design P1 100 years": [90.0, 100.0, None]}
    assert (
        deviations(before, {"posterior base a": [0.5009, 0.0109], **dict(list(before.items())[1:])})
        == {}
    )
    now = {"posterior base a": [0.502, 0.01], "design P1 100 years": [90.0, 106.0, None]}
    assert set(deviations(before, now)) == set(before)
    assert deviations({"missing": []}, {"missing": ["season"]}) == {"missing": [[], ["season"]]}
    assert set(deviations({"elpd base": -10.0}, {"gain season": 1.0})) == {
        "elpd base",
        "gain season",
    }


def test_exceptions_take_the_place_of_references() -> None:
    kept = {
        "references": {"twin": {"verdict": "adequate", "n events": 3}},
        "exceptions": {"twin": {"verdict": ["ambiguous", "why"]}},
    }
    assert references(kept, "twin") == {"verdict": "ambiguous", "n events": 3}
