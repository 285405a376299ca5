"""The verdict that follows from the leading candidates."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.diagnosis.refits import refit
from avahazard.criticism.diagnosis.verdict import (
    MARGIN,
    evidence_gain,
    groups_earn_their_name,
    least_evidence,
    verdict_of,
)
from avahazard.effects.catalogue import definition
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from tests.criticism.lengths import lengths, shifted

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
    ("key", "screened", "chance", "expected"),
    [
        ("season", 4.0, 2.0, 5.0),
        ("observation-limit", 8.0, 2.0, 6.0 - 2.0 * 0.75),  # 6 in full, 8 in the screening
        ("observation-limit", 3.0, 2.0, 6.0 - 2.0),  # never more than all that chance gives
        ("observation-limit", 8.0, 0.4, 5.0),  # the price of its parameter is more
    ],
)
def test_the_estimated_limit_pays_one_price(
    key: str, screened: float, chance: float, expected: float
) -> None:
    fit: Any = SimpleNamespace(evidence=15.0, log_likelihood=26.0)
    base: Any = SimpleNamespace(evidence=10.0, log_likelihood=20.0)
    candidate: Any = SimpleNamespace(definition=definition(key), gain=screened, null_mean=chance)
    assert evidence_gain(candidate, fit, base) == pytest.approx(expected)


def test_winters_need_evidence_for_a_name() -> None:
    records = lengths(48, 0.0, seed=3)
    winters = np.arange(48) // 6
    dates = [f"{1950 + w}-02-01" for w in winters]
    named = []
    for spread in (0.0, 0.3):
        shift = spread * np.random.default_rng(7).standard_normal(8)[winters]
        moved = shifted(records, {}, shift)
        events = tuple(replace(e, date=d) for e, d in zip(moved.events, dates, strict=True))
        observations = build_observations(replace(moved, events=events))
        base = refit(observations, Specification(law="power"), {}, ("winter-effect",))
        named.append(groups_earn_their_name(observations, (), base, "winter-effect"))
    assert named == [False, True]
