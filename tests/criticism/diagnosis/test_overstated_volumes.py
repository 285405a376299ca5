"""Another law is not blamed alone where volumes are merely recorded worse than stated."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from avahazard.criticism.diagnosis.misstated_volumes import by_misstated_volumes
from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.effects.catalogue import catalogue
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.making import make_world
from avahazard.synth.settings import Settings

LAW, ERROR = "volume-law", "volume-error"
STATED = 0.3
SCREENED = SimpleNamespace(candidates=[SimpleNamespace(key=ERROR, definition=catalogue()[ERROR])])


def _world(seed: int, effects: dict[str, float], error: float) -> Observations:
    records, _ = make_world(seed, 120, 9, effects, Settings(volume_rel_sigma=error))
    events = tuple(replace(e, volume_rel_sigma=STATED) for e in records.events)
    return build_observations(replace(records, events=events))


def _asked(observations: Observations) -> tuple[float, str | None]:
    """Evidence of another law over the model's, and what leaves it too little."""
    base = refit(observations, Specification(), {}, ("path-effect",))
    other = refit(observations, base.specification, base.facts, (LAW,), (), base)
    fits: dict[str, Refit] = {LAW: other}
    found = by_misstated_volumes(observations, (), base, fits, LAW, SCREENED)  # type: ignore[arg-type]
    return other.evidence - base.evidence, found


@pytest.mark.slow
def test_large_records_of_small_volumes_are_no_law_with_a_limit() -> None:
    gain, found = _asked(_world(910001, {}, 1.0))
    assert gain > 6.0
    assert found == ERROR


@pytest.mark.slow
def test_a_true_other_law_keeps_its_evidence() -> None:
    gain, found = _asked(_world(920001, {LAW: 1.0}, STATED))
    assert gain > 6.0
    assert found is None
