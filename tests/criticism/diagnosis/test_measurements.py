from __future__ import annotations

import numpy as np
import pytest

from avahazard.criticism.diagnosis import measurements
from avahazard.criticism.diagnosis.measurements import (
    measurement_gains,
    record_gain,
    speed_gain,
)
from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from tests.criticism.lengths import lengths
from tests.inference import studies


def test_speeds_part_what_moves_at_other_speeds() -> None:
    observations = studies.observations(speeds=False)
    base = refit(observations, Specification(), {})
    assert speed_gain(base, base, 10, 3, 1) == 0.0
    drag = refit(observations, base.specification, base.facts, ("turbulent-drag",), (), base)
    slot = drag.posterior.layout.places["turbulent-drag"].start
    gains = []
    for value in (0.4, 1.2):
        drag.mode.u[slot] = value
        gains.append(speed_gain(drag, base, 20, 1, 1))
    assert 1.0 < gains[0] < gains[1]
    assert speed_gain(base, drag, 20, 1, 1) == pytest.approx(gains[1], rel=0.2)
    assert speed_gain(drag, base, 20, 8, 1) > gains[1]


def test_they_come_best_first(monkeypatch: pytest.MonkeyPatch) -> None:
    observations = studies.observations(speeds=False)
    base = refit(observations, Specification(), {})
    snow = refit(observations, base.specification, base.facts, ("snow-type",), (), base)
    # So few events would part them that nothing is advised.
    assert not measurement_gains(snow, base, seed=3)
    monkeypatch.setattr(measurements, "LEAST_GAIN", 0.0)
    found = measurement_gains(snow, base, seed=3)
    gains = [m.expected_gain for m in found]
    assert gains == sorted(gains, reverse=True)
    assert len({m.measurement for m in found}) == len(found) == 4
    assert found == measurement_gains(snow, base, seed=3)


def test_without_a_profile_only_events_can_be_measured() -> None:
    observations = build_observations(lengths(60, slope=0.1))
    base = refit(observations, Specification(law="power"), {})
    other = refit(observations, base.specification, base.facts, ("covariate:column_1",), (), base)
    found = measurement_gains(other, base)
    assert len(found) == 1
    assert "more events" in found[0].measurement
    # As many more events as there are would gain as much as these did.
    gained = other.log_likelihood - base.log_likelihood
    assert float(np.sum(record_gain(other, base))) == pytest.approx(gained, rel=0.3)


def test_columns_that_go_together_are_to_be_parted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measurements, "LEAST_GAIN", 0.0)
    observations = build_observations(lengths(60, slope=0.1))
    base = refit(observations, Specification(law="power"), {})
    pair = [
        refit(observations, base.specification, base.facts, (f"covariate:column_{k}",), (), base)
        for k in (1, 2)
    ]
    texts = [m.measurement for m in measurement_gains(*pair)]
    assert any("covariate:column_1 and covariate:column_2" in text for text in texts)
