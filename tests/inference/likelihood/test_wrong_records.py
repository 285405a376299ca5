"""Grossly wrong records: what they cost, and that no effect lives on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.likelihood.wrong_records import log_wrong, wrong_ranges
from avahazard.inference.model.observations import ELEVATION, LEFT, Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.making import make_world
from avahazard.synth.settings import Settings


@pytest.fixture(scope="module")
def observations() -> Observations:
    records, _ = make_world(11, 60, 5, {}, Settings(speeds=0.1))
    return build_observations(records)


def test_a_wrong_record_lies_anywhere_on_its_path(observations: Observations) -> None:
    low, high = wrong_ranges(observations)
    density = log_wrong(observations)
    tracks = {m.event for m in observations.speeds}
    assert tracks
    for i in range(observations.n_events):
        if observations.kind[i] == LEFT or i in tracks:
            assert density[i] == -np.inf
            continue
        assert high[i] - low[i] > 100.0
        assert density[i] == pytest.approx(-np.log(high[i] - low[i]))


def test_a_record_where_nothing_stops_costs_no_more_than_a_wrong_one(
    observations: Observations,
) -> None:
    """With normal tails it asks for any effect that moves it."""
    i = int(
        np.flatnonzero((observations.kind == ELEVATION) & np.isfinite(log_wrong(observations)))[0]
    )
    top = observations.sites[observations.columns.path_index[i]].terrain.y.max()
    observed = observations.observed.copy()
    observed[i] = top - 30.0
    moved = replace(observations, observed=observed)
    cost, wrong = {}, 0.0
    for tails in ("normal", "student"):
        fit = refit(moved, Specification(tails=tails), {}, ())  # type: ignore[arg-type]
        cost[tails] = fit.posterior.event_log_likelihood(fit.mode.u)[i]
        wrong = fit.posterior.log_wrong(fit.mode.u)[i]
    assert cost["student"] == pytest.approx(wrong, abs=0.1)
    assert cost["normal"] < cost["student"] - 5.0


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_share_of_wrong_records_is_found(share: float) -> None:
    records, _ = make_world(12, 150, 5, {}, Settings(wrong_share=share))
    fit = refit(build_observations(records), Specification(law="constant", tails="student"), {}, ())
    found = fit.parameters("")
    # Those that lie where a right one may lie are not told, and the prior expects few.
    assert found["wrong_share"] < 0.03 if share == 0.0 else 0.5 * share < found["wrong_share"] < 0.4
    assert 0.1 < found["sigma"] < 0.25
