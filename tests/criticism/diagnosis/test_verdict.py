"""The verdict that follows from the leading candidates."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from avahazard.criticism.diagnosis.verdict import (
    MARGIN,
    evidence_gain,
    least_evidence,
    verdict_of,
)
from avahazard.effects.catalogue import definition

FOREST, SEASON = definition("forest-drag"), definition("season")
WIND, SNOW = definition("covariate:wind"), definition("covariate:snow_type")


@pytest.mark.parametrize(
    ("named", "verdict"),
    [
        ((), "adequate"),
        ((FOREST,), "missing-effect"),
        ((FOREST, SEASON), "ambiguous"),
        ((WIND,), "unexplained"),
        ((WIND, SNOW), "unexplained"),
        ((WIND, SEASON), "ambiguous"),
    ],
)
def test_only_a_cause_is_a_missing_effect(named: tuple[Any, ...], verdict: str) -> None:
    assert verdict_of(named) == (verdict, tuple(entry.key for entry in named))


def test_a_curve_over_a_column_needs_no_margin() -> None:
    assert least_evidence(FOREST) == MARGIN
    assert least_evidence(WIND) == 0.0


@pytest.mark.parametrize(
    ("limit", "screened", "expected"),
    [
        (None, 4.0, 5.0),
        (lambda *_: 0.0, 8.0, 5.0 - 2.0 * 0.75),  # a gain of 6 in full, of 8 in the screening
        (lambda *_: 0.0, 3.0, 5.0 - 2.0),  # never more than the whole of what chance gives
    ],
)
def test_the_estimated_limit_pays_for_what_it_gains_by_chance(
    limit: Any, screened: float, expected: float
) -> None:
    effect = SimpleNamespace(key="observation-limit", limit=limit)
    fit: Any = SimpleNamespace(
        evidence=15.0, log_likelihood=26.0, posterior=SimpleNamespace(effects=(effect,))
    )
    base: Any = SimpleNamespace(evidence=10.0, log_likelihood=20.0)
    candidate: Any = SimpleNamespace(
        definition=definition("observation-limit"), gain=screened, null_mean=2.0
    )
    assert evidence_gain(candidate, fit, base) == pytest.approx(expected)
