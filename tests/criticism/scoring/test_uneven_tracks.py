"""Friction that goes up and down along its tracks: its size, the intervals, and what is named."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from avahazard.criticism.diagnosis.diagnose import Findings, diagnose
from avahazard.criticism.diagnosis.force_witness import ForceWitness
from avahazard.criticism.scoring.scores import randomised_pit
from avahazard.criticism.scoring.speed_misfit import matched_speeds
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.fitting.mode import Mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from tests.criticism.studies import draws_about, fitted
from tests.criticism.uneven_tracks import made


@cache
def fit(uneven: float) -> tuple[Posterior, Mode]:
    return fitted(made(21, uneven))


@pytest.mark.parametrize("uneven", [0.03, 0.1])
def test_the_scatter_along_the_tracks_is_found(uneven: float) -> None:
    posterior, mode = fit(uneven)
    place = posterior.layout.track_scatter
    off = (mode.u[place] - np.log(uneven)) / np.sqrt(mode.covariance[place, place])
    assert abs(off) < 2.5
    assert np.exp(mode.u[place]) == pytest.approx(uneven, rel=0.3)


def test_friction_that_is_even_has_next_to_none() -> None:
    posterior, mode = fit(0.0)
    assert np.exp(mode.u[posterior.layout.track_scatter]) < 0.015


@pytest.mark.parametrize("uneven", [0.0, 0.03, 0.1])
def test_intervals_hold_the_speeds_of_avalanches_not_seen(uneven: float) -> None:
    posterior, mode = fit(uneven)
    u = np.clip(draws_about(mode, 100), posterior.layout.low, posterior.layout.high)
    others = fitted_model(posterior, u, {}).on(build_observations(made(22, uneven, n_events=40)))
    found = matched_speeds(others, np.random.default_rng(1))
    assert found is not None
    pit = randomised_pit(found.draws, found.observed, np.random.default_rng(2))
    assert 0.82 < np.mean(np.abs(pit - 0.5) < 0.45) < 0.97
    assert 0.38 < np.mean(np.abs(pit - 0.5) < 0.25) < 0.65


def asked(seed: int, drag: float) -> Findings:
    records = made(seed, 0.1, drag=drag, level=0.33 if drag else 0.45, share=0.5)
    return diagnose(build_observations(records), Specification(law="constant"), {})


@pytest.mark.slow
def test_uneven_friction_is_no_effect_on_the_motion() -> None:
    assert asked(13, 0.0).result.verdict == "adequate"


@pytest.mark.slow
def test_drag_is_named_where_friction_is_uneven() -> None:
    found = asked(11, 0.002)
    assert (found.result.verdict, found.result.missing) == ("missing-effect", ("turbulent-drag",))
    drag = next(c for c in found.result.candidates if c.effect == "turbulent-drag")
    witness, (fitted,) = drag.force_witness, drag.parameters.values()
    assert witness is not None
    assert not ForceWitness(witness.value, witness.se, fitted).denies
    assert witness.value == pytest.approx(0.002, rel=0.3)
