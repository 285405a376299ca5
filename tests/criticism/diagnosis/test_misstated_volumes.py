from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from avahazard.criticism.diagnosis import misstated_volumes
from avahazard.criticism.diagnosis.misstated_volumes import by_misstated_volumes
from avahazard.effects.catalogue import definition
from avahazard.inference.model.observations import build_observations
from tests.criticism.studies import straight

LAW, SCATTER, SEASON, ERROR = "volume-law", "volume-scatter", "season", "volume-error"


def fit(evidence: float) -> Any:
    return SimpleNamespace(evidence=evidence, specification=None, facts={})


@pytest.mark.parametrize(
    ("leader", "beside", "expected"),
    [(LAW, 21.0, ERROR), (LAW, 27.0, None), (SCATTER, 21.0, ERROR), (SEASON, 21.0, None)],
)
def test_what_is_of_the_volume_must_earn_its_evidence_beside_its_errors(
    monkeypatch: pytest.MonkeyPatch, leader: str, beside: float, expected: str | None
) -> None:
    observations = build_observations(straight(20))
    screening: Any = SimpleNamespace(
        candidates=[SimpleNamespace(key=k, definition=definition(k)) for k in (leader, ERROR)]
    )
    monkeypatch.setattr(misstated_volumes, "refit", lambda *_: fit(beside))
    fits = {leader: fit(30.0), ERROR: fit(20.0)}
    found = by_misstated_volumes(observations, (), fit(0.0), fits, leader, screening)
    assert found == expected
    stated: Any = SimpleNamespace(candidates=[])
    assert by_misstated_volumes(observations, (), fit(0.0), fits, leader, stated) is None
