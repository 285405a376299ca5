"""Edges of sight in friction, against looking stops up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.likelihood.sight import hidden_from
from avahazard.inference.model.observations import ELEVATION
from avahazard.inference.prediction.stops import look_up
from avahazard.physics.runout_curve import MU
from tests.inference import studies


@pytest.mark.parametrize("jump_m", [0.0, 400.0])
def test_stops_below_the_edge_are_seen_and_those_above_are_not(jump_m: float) -> None:
    observations = studies.observations(speeds=False)
    predicted = predict_records(observations, (), {})
    i = int(np.flatnonzero(observations.kind == ELEVATION)[0])
    # From some friction on blocks stop much higher.
    after = np.arange(len(MU)) > np.searchsorted(-predicted.x[i], -900.0)
    x, elevation = predicted.x.copy(), predicted.elevation.copy()
    x[i, after] -= jump_m
    elevation[i, after] += 0.5 * jump_m
    predicted = replace(predicted, x=x, elevation=elevation)
    j = int(np.flatnonzero(after)[0])
    limits = observations.limit.copy()
    limits[i] = 0.9 * elevation[i, j - 1] + 0.1 * elevation[i, j]
    observations = replace(observations, limit=limits)
    edge = hidden_from(observations, predicted, in_log=False)[i]
    assert MU[j - 1] < edge < MU[j]
    assert predicted.curve[i].broken[j - 1] == bool(jump_m)
    for friction, seen in ((edge - 1e-5, True), (edge + 1e-5, False)):
        stop = look_up(predicted, np.full((observations.n_events, 1), friction))[2][i, 0]
        assert (stop <= limits[i]) == seen
