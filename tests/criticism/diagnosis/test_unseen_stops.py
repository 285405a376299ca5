from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from avahazard.criticism.diagnosis import unseen_stops
from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.criticism.diagnosis.unseen_stops import by_what_is_seen
from avahazard.effects.catalogue import definition
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.making import make_world

DRAG, SEASON, SIGHT = "turbulent-drag", "season", "observation-limit"


def fit(evidence: float, key: str = SEASON) -> Any:
    posterior = SimpleNamespace(effects=(definition(key).build({}),))
    return SimpleNamespace(evidence=evidence, posterior=posterior)


def screened(gain: float) -> Any:
    """Both among the candidates, each with this gain."""
    return SimpleNamespace(
        candidates=[
            SimpleNamespace(key=k, definition=definition(k), gain=gain) for k in (DRAG, SIGHT)
        ]
    )


@pytest.mark.parametrize(
    ("leader", "beside", "expected"),
    [(DRAG, 21.0, SIGHT), (DRAG, 27.0, None), (SEASON, 21.0, None)],
)
def test_a_force_must_earn_its_evidence_beside_what_is_seen(
    monkeypatch: pytest.MonkeyPatch, leader: str, beside: float, expected: str | None
) -> None:
    screening = screened(8.0)
    monkeypatch.setattr(unseen_stops, "refit_side_by_side", lambda *_: iter([fit(beside)]))
    fits = {leader: fit(10.0, leader), SIGHT: fit(20.0)}
    nothing: Any = None
    base: Any = SimpleNamespace(specification=Specification(), evidence=0.0)
    assert by_what_is_seen(nothing, (), base, fits, leader, screening) == expected
    known: Any = SimpleNamespace(candidates=[])
    assert by_what_is_seen(nothing, (), base, fits, leader, known) is None
    base.specification = Specification(effects=(SIGHT,))
    assert by_what_is_seen(nothing, (), base, fits, leader, screening) is None


def test_a_limit_that_gains_too_little_to_take_the_evidence_is_not_fitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []

    def refit(*given: Any) -> Any:
        asked.append(given)
        return iter([fit(20.0), fit(20.0)])

    monkeypatch.setattr(unseen_stops, "refit_side_by_side", refit)
    nothing: Any = None
    base: Any = SimpleNamespace(specification=Specification(), evidence=-100.0)
    fits = {DRAG: fit(-40.0, DRAG)}
    assert by_what_is_seen(nothing, (), base, fits, DRAG, screened(5.0)) is None
    assert not asked
    assert by_what_is_seen(nothing, (), base, fits, DRAG, screened(40.0)) == SIGHT
    assert len(asked) == 1


@pytest.mark.slow
def test_short_runouts_that_nobody_saw_are_named_and_no_force() -> None:
    named = []
    for seed in range(900010, 900014):
        n_events, n_paths = (120, 9) if seed % 2 else (250, 11)
        records, _ = make_world(seed, n_events, n_paths, {SIGHT: 1.0})
        named.append(diagnose(build_observations(records), Specification(), {}).missing)
    assert sum(SIGHT in missing for missing in named) >= 3
    assert not any(DRAG in missing for missing in named)
