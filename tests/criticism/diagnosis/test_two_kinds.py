"""Two kinds of avalanche: what is found of them, what they have in common, and what chance does."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.criticism.diagnosis.full_fits import (
    CHANCE_GAIN,
    gain_of_wrong_records,
    kinds_of,
    second_kind,
)
from avahazard.criticism.diagnosis.naming import MARGIN
from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Event, Records

CONSTANT = Specification(law="constant")
SIGMA, SHARE, SHIFT = 0.07, 0.35, -0.27


def straight(seed: int, share: float = SHARE, wrong: float = 0.0, n: int = 150) -> Observations:
    """Events without a profile, of two kinds; of wrong records the length is anywhere."""
    rng = np.random.default_rng(seed)
    second = rng.uniform(size=n) < share
    friction = np.exp(-0.7 + SHIFT * second + SIGMA * rng.normal(size=n))
    length = 500.0 / friction + 10.0 * rng.normal(size=n)
    length = np.where(rng.uniform(size=n) < wrong, rng.uniform(400.0, 1600.0, n), length)
    # Four in five of the second kind fell in clear weather, of the others half.
    clear = rng.uniform(size=n) < np.where(second, 0.8, 0.5)
    events = tuple(
        Event(
            f"e{i}",
            fall_height_m=500.0,
            runout_length_m=float(length[i]),
            runout_sigma_m=10.0,
            covariates={
                "weather": "clear" if clear[i] else "storm",
                "wind": float(rng.normal()),
                "second": float(second[i]),
            },
        )
        for i in range(n)
    )
    return build_observations(Records((), (), events))


def fits(observations: Observations) -> tuple[Refit, Refit]:
    """The model with one kind, and with two."""
    base = refit(observations, CONSTANT, {})
    return base, refit(observations, CONSTANT, {}, ("two-kinds",), (), base)


def test_share_shift_and_the_kind_of_each_event_are_found() -> None:
    observations = straight(1)
    base, fit = fits(observations)
    found = fit.parameters("two-kinds")
    truth = observations.columns.numbers["second"]
    assert found["two-kinds.share"] == pytest.approx(float(np.mean(truth)), abs=0.08)
    assert found["two-kinds.shift"] == pytest.approx(SHIFT, abs=0.05)
    assert fit.parameters("sigma")["sigma"] == pytest.approx(SIGMA, abs=0.02)
    assert fit.evidence - base.evidence > 5.0
    probability = second_kind(fit.at_mode(), 0, None)
    assert np.mean((probability > 0.5) == (truth == 1.0)) > 0.9
    assert np.sum(probability) == pytest.approx(found["two-kinds.share"] * len(truth), rel=0.1)


def test_what_the_kinds_have_in_common_is_found_among_the_columns() -> None:
    base, fit = fits(straight(2))
    assert kinds_of(base.at_mode()) is None
    found = kinds_of(fit.at_mode())
    assert found is not None
    assert (found.share, found.shift) == tuple(fit.parameters("two-kinds").values())
    assert len(found.probability) == 150
    by_column = {row.column: row for row in found.in_common}
    assert set(by_column) == {"second", "weather"}
    assert by_column["second"].correlation > 0.7
    # The level that is shown is the second in the alphabet.
    assert by_column["weather"].level == "storm"
    assert by_column["weather"].correlation < 0.0


def test_wrong_records_are_no_second_kind() -> None:
    base, fit = fits(straight(3, share=0.0, wrong=0.2))
    assert gain_of_wrong_records(base) > fit.log_likelihood - base.log_likelihood
    base, fit = fits(straight(3))
    assert fit.evidence - base.evidence - gain_of_wrong_records(base) > MARGIN


def test_a_second_kind_is_named_and_its_model_is_adequate() -> None:
    events = straight(4)
    events.columns.numbers.pop("second")  # type: ignore[attr-defined]
    found = diagnose(events, CONSTANT, {})
    assert (found.result.verdict, found.result.missing) == ("missing-effect", ("two-kinds",))
    best = found.result.candidates[0]
    assert best.kinds is not None
    assert best.p_value_alone == pytest.approx(np.exp(-best.screened_gain / CHANCE_GAIN))
    wider = Specification(law="constant", effects=("two-kinds",))
    assert diagnose(events, wider, {}).result.verdict == "adequate"


@pytest.mark.slow
def test_chance_gains_no_more_than_its_law_says() -> None:
    gains = []
    for seed in range(200):
        base, fit = fits(straight(1000 + seed, share=0.0, n=60 + 100 * (seed % 2)))
        gains.append(fit.log_likelihood - base.log_likelihood)
    p = np.exp(-np.maximum(gains, 0.0) / CHANCE_GAIN)
    for level in (0.005, 0.05, 0.2):
        assert stats.binomtest(int(np.sum(p <= level)), 200, level, "greater").pvalue > 0.01
