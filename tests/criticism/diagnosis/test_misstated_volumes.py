from __future__ import annotations

from dataclasses import replace
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
    ("leader", "beside", "overstated", "expected"),
    [
        (LAW, 21.0, 20.0, ERROR),
        (LAW, 27.0, 20.0, None),
        (LAW, 27.0, 26.0, ERROR),
        (SCATTER, 21.0, 20.0, ERROR),
        (SEASON, 21.0, 20.0, None),
    ],
)
def test_what_is_of_the_volume_must_earn_its_evidence_beside_its_errors(
    monkeypatch: pytest.MonkeyPatch,
    leader: str,
    beside: float,
    overstated: float,
    expected: str | None,
) -> None:
    """`overstated` is the evidence of the errors where many records are over any true volume."""
    records = straight(20)
    events = (replace(e, volume_m3=1e4 * (k + 1)) for k, e in enumerate(records.events))
    observations = build_observations(replace(records, events=tuple(events)))
    screening: Any = SimpleNamespace(
        candidates=[SimpleNamespace(key=k, definition=definition(k)) for k in (leader, ERROR)]
    )
    base, first = fit(0.0), fit(30.0)

    def refitted(*told: Any) -> Any:
        return fit(beside if told[-1] is first else overstated)

    monkeypatch.setattr(misstated_volumes, "refit", refitted)
    fits = {leader: first, ERROR: fit(20.0)}
    found = by_misstated_volumes(observations, (), base, fits, leader, screening)
    assert found == expected
    stated: Any = SimpleNamespace(candidates=[])
    assert by_misstated_volumes(observations, (), fit(0.0), fits, leader, stated) is None
