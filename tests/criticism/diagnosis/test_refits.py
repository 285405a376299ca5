from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.diagnosis import refits
from avahazard.criticism.diagnosis.refits import (
    refit,
    refit_each,
    refit_with,
    refit_without,
    still_needed,
)
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from tests.criticism.lengths import lengths
from tests.inference import studies

PATH_EFFECT, DRAG = "path-effect", "turbulent-drag"


def test_a_needless_effect_costs_evidence_and_a_true_one_pays() -> None:
    observations = build_observations(lengths(90, slope=0.1))
    base = refit(observations, Specification(law="power"), {})
    true = refit(observations, base.specification, base.facts, ("covariate:column_1",), (), base)
    needless = refit(
        observations, base.specification, base.facts, ("covariate:column_2",), (), base
    )
    assert true.evidence > base.evidence + 3.0
    assert needless.evidence < base.evidence
    assert needless.mode.log_density >= base.mode.log_density - 1e-3
    slope = true.parameters("covariate:column_1")["covariate:column_1.slope"]
    assert slope == pytest.approx(0.1, abs=0.06)


def test_the_start_does_not_change_the_mode() -> None:
    observations = build_observations(lengths(60, slope=0.1))
    base = refit(observations, Specification(law="power"), {})
    started = refit(observations, base.specification, base.facts, ("covariate:column_1",), (), base)
    fresh = refit(observations, base.specification, base.facts, ("covariate:column_1",))
    assert started.mode.log_density == pytest.approx(fresh.mode.log_density, abs=0.01)


def test_another_law_starts_at_the_data() -> None:
    observations = build_observations(lengths(60))
    base = refit(observations, Specification(), {})
    other = refit(observations, base.specification, base.facts, ("volume-law",), (), base)
    assert other.specification.law != "exponential"
    assert other.log_likelihood > base.log_likelihood - 3.0


def test_an_effect_is_taken_away_and_the_others_stay() -> None:
    observations = studies.observations(speeds=False)
    fit = refit(observations, Specification(), {}, (PATH_EFFECT, "snow-type"))
    bare = refit_without(fit, PATH_EFFECT)
    assert not bare.posterior.plan
    assert [e.key for e in bare.posterior.effects] == ["snow-type"]
    fresh = refit(observations, Specification(), {}, ("snow-type",))
    assert bare.mode.log_density == pytest.approx(fresh.mode.log_density, abs=0.01)


def test_what_shapes_no_tables_is_fitted_on_the_star_that_is_there() -> None:
    observations = studies.observations()
    base = refit(observations, Specification(), {})
    wider = refit_with(base, "snow-type")
    assert wider.posterior.nodes._chart is base.posterior.nodes._chart
    fresh = refit(observations, Specification(), {}, ("snow-type",))
    assert fresh.posterior.nodes._chart is not base.posterior.nodes._chart
    assert wider.log_likelihood == pytest.approx(fresh.log_likelihood, abs=0.1)
    assert wider.evidence == pytest.approx(fresh.evidence, abs=0.3)
    # An effect on the motion needs a star of its own.
    other = refit_with(base, DRAG)
    assert other.posterior.nodes._chart is not base.posterior.nodes._chart


def test_what_gains_too_little_has_no_evidence() -> None:
    observations = studies.observations()
    base = refit(observations, Specification(), {})
    fit = refit_with(base, DRAG)
    worth = refit_each(base, [DRAG], least={DRAG: 1.0})[DRAG]
    assert worth.evidence == pytest.approx(fit.evidence, abs=0.2)
    gain = fit.log_likelihood - base.log_likelihood
    needless = refit_each(base, [DRAG], least={DRAG: gain + 0.5})[DRAG]
    assert needless.evidence == -np.inf


EVIDENCE = {("season",): -12.0, ("snow-type",): -9.0}


def test_a_loss_is_what_the_others_alone_lack(monkeypatch: pytest.MonkeyPatch) -> None:
    def refitted(_observations: Any, specification: Specification, *_: Any) -> Any:
        return SimpleNamespace(evidence=EVIDENCE[specification.effects])

    monkeypatch.setattr(refits, "refit", refitted)
    specification = Specification(effects=("snow-type", "season"))
    whole: Any = SimpleNamespace(
        evidence=-10.0, specification=specification, facts={}, observations=None, own=()
    )
    lost = still_needed(whole)
    assert lost == {"snow-type": 2.0, "season": -1.0}
