"""Grossly wrong records: what they cost, and that no effect lives on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.likelihood.wrong_records import WRONG_SHARE, log_wrong, wrong_ranges
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
        assert density[i] == pytest.approx(np.log(WRONG_SHARE) - np.log(high[i] - low[i]))


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
    cost = {}
    for tails in ("normal", "student"):
        fit = refit(moved, Specification(tails=tails), {}, ())  # type: ignore[arg-type]
        cost[tails] = fit.posterior.event_log_likelihood(fit.mode.u)[i]
    assert cost["student"] == pytest.approx(log_wrong(observations)[i], abs=0.1)
    assert cost["normal"] < cost["student"] - 5.0
