"""How wide the prior of a level is: by how much the records spread."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.effects.levels import LEAST_SD, SCATTERS, level_effect, level_facts
from avahazard.inference.fitting.evidence import log_evidence
from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from tests.criticism.studies import levelled, slopes, straight
from tests.effects.event_table import event_table

CONSTANT = Specification(law="constant")


def test_the_width_is_that_of_the_records_in_log_friction() -> None:
    observations = build_observations(levelled(0.0, 40))
    facts = level_facts(observations.columns, "rock")
    spread = np.std(np.log(observations.columns.height_over_length))
    assert facts["prior_sd"] == pytest.approx(SCATTERS * spread, abs=1e-3)
    (parameter,) = level_effect("k", "rock", facts).parameters
    assert parameter.prior_sd == facts["prior_sd"]


def test_no_narrower_than_before_where_nothing_tells_it() -> None:
    rock = ["a"] * 9 + ["b"] * 9
    assert level_facts(event_table(rock=rock), "rock")["prior_sd"] == LEAST_SD
    (old,) = level_effect("k", "rock", {"reference": "a", "levels": ["b"]}).parameters
    assert old.prior_sd == LEAST_SD


def test_the_line_to_the_stop_is_the_same_for_either_kind_of_record() -> None:
    by_x = build_observations(slopes(kind="x")).columns.height_over_length
    by_height = build_observations(slopes(kind="elevation")).columns.height_over_length
    assert by_x == pytest.approx(by_height, rel=0.02)
    stops = np.array([e.runout_x_m for e in slopes(kind="x").events], float)
    assert by_x == pytest.approx((stops - 2.5e-4 * stops**2) / stops, rel=0.01)
    lines = build_observations(straight())
    assert lines.columns.height_over_length == pytest.approx(1000.0 / lines.observed)


def fit(shift: float, n_level: int, seed: int) -> tuple[float, float, float]:
    """Shift at the mode, its standard deviation, and the evidence (nats) that the level adds."""
    observations = build_observations(levelled(shift, n_level, seed))
    base = assemble(observations, CONSTANT, {})
    specification, facts = with_effects(observations, CONSTANT, ("covariate:rock",))
    posterior = assemble(observations, specification, facts)
    mode, plain = find_mode(posterior), find_mode(base)
    gain = log_evidence(posterior, mode).value - log_evidence(base, plain).value
    scale = posterior.layout.slots[-1].scale
    assert scale == facts["covariate:rock"]["prior_sd"]
    return scale * mode.u[-1], scale * float(np.sqrt(mode.covariance[-1, -1])), gain


def test_a_shift_of_a_half_comes_back_whole_from_few_events() -> None:
    found = np.array([fit(0.5, 6, seed) for seed in range(8)])
    middle, sd = found[:, 0], found[:, 1]
    # With a prior of 0 ± 0.2 the mean fell short by a tenth.
    assert np.mean(middle) == pytest.approx(0.5, abs=2.0 * np.mean(sd) / np.sqrt(8))
    assert np.mean(np.abs(middle - 0.5) < 1.64 * sd) >= 0.7
    assert np.all(found[:, 2] > 3.0)


def test_a_level_that_does_nothing_costs_its_price() -> None:
    gains = np.array([fit(0.0, 20, seed)[2] for seed in range(8)])
    # E exp(gain) = 1 where nothing is there: odds of 20 to 1 come once in 20 at most.
    assert np.mean(gains) < -0.7
    assert np.sum(gains > np.log(20.0)) <= 1
