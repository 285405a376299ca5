from __future__ import annotations

from dataclasses import replace

import pytest

from avahazard.criticism.diagnosis import nuisances
from avahazard.criticism.diagnosis.nuisances import with_nuisances_granted
from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from tests.criticism.lengths import lengths

WINTERS, STORMS = "winter-effect", "storm-effect"


def test_groups_too_many_to_cross_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    records = lengths(48, 0.0, seed=3)
    # Two storms of four in each of six winters.
    dates = [f"{1950 + i // 8}-02-{1 + 9 * (i % 8 // 4):02d}" for i in range(48)]
    events = tuple(replace(e, date=d) for e, d in zip(records.events, dates, strict=True))
    observations = build_observations(replace(records, events=events))
    plain = refit(observations, Specification(law="power"), {})
    monkeypatch.setattr(nuisances, "MOST_CROSSED", -1)
    found = with_nuisances_granted(observations, plain, ())
    assert set(found.too_many) == {WINTERS, STORMS}
    assert found.granted == ()
    monkeypatch.setattr(nuisances, "MOST_CROSSED", 150)
    assert with_nuisances_granted(observations, plain, ()).too_many == ()
