"""Rock avalanches of Canada: confinement comes nearest to mattering, substrate does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.criticism.diagnosis.diagnose import Findings, diagnose
from avahazard.criticism.diagnosis.refits import refit
from avahazard.criticism.scoring.held_out import choose_groups, held_out_together
from avahazard.criticism.screening.screen import LEVEL
from avahazard.effects.covariate import VOLUME_PER
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.reading import read_records

CONFINEMENT, SUBSTRATE = "covariate:confinement", "covariate:substrate"


@pytest.fixture(scope="module")
def found(shared_data: Path) -> Findings:
    observations = build_observations(read_records([shared_data / "rock-avalanches-canada"]))
    return diagnose(observations, Specification(law="power"), {})


def test_confinement_leads_and_substrate_is_nothing(found: Findings) -> None:
    by_key = {c.key: c for c in found.screening.candidates}
    best = min((c for c in by_key.values() if c.definition.beyond < 2), key=lambda c: c.p_single)
    assert best.key == CONFINEMENT
    # The volume over the area of the deposit, its thickness, leads by a little (p 0.05).
    leading = (c.effect for c in found.result.candidates if VOLUME_PER not in c.effect)
    assert CONFINEMENT.partition(":")[2] in next(leading)
    assert by_key[CONFINEMENT].p_single < 0.05
    assert by_key[SUBSTRATE].p_single > 0.3


def test_among_all_columns_tried_49_events_cannot_tell(found: Findings) -> None:
    assert found.result.verdict == "adequate"
    assert found.result.candidates[0].p_value > LEVEL


def test_held_out_records_ask_for_confinement_alone(found: Findings) -> None:
    base = found.base
    observations = base.posterior.observations
    groups = choose_groups(observations).groups
    before = held_out_together(base.posterior, groups, base.mode).sum()
    gains = {}
    for key in (CONFINEMENT, SUBSTRATE):
        child = refit(observations, base.specification, base.facts, (key,), (), base)
        gains[key] = held_out_together(child.posterior, groups, child.mode).sum() - before
    assert gains[CONFINEMENT] > 0.0
    assert gains[SUBSTRATE] < 0.0


def test_the_fall_height_is_not_proposed_but_added_unmasks_it(found: Findings) -> None:
    base = found.base
    observations = base.posterior.observations
    height = "covariate:fall_height_m"
    assert not any("fall_height_m" in c.effect for c in found.result.candidates)
    taller = refit(observations, base.specification, base.facts, (height,), (), base)
    both = refit(observations, taller.specification, taller.facts, (CONFINEMENT,), (), taller)
    by_itself = refit(observations, base.specification, base.facts, (CONFINEMENT,), (), base)
    gain = both.log_likelihood - taller.log_likelihood
    assert gain > by_itself.log_likelihood - base.log_likelihood + 1.0
