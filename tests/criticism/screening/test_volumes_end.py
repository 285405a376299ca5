"""That true volumes end somewhere is no missing effect, in however large a region."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.diagnosis.refits import refit
from avahazard.criticism.screening.screen import screen
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.model.volumes import bounded
from avahazard.synth.making import make_dataset

KEYS = ("volume-law", "cohesion")


def _gains(observations: Observations) -> dict[str, float]:
    """Gains of the `KEYS` over what chance exceeds in one of twenty cases."""
    fit = refit(observations, Specification(), {}, ("path-effect",))
    found = screen(fit.posterior, fit.mode.u, [find_definition(k) for k in KEYS])
    return {c.key: c.gain - c.null_gain for c in found.candidates}


@pytest.mark.slow
def test_of_20_000_events_other_laws_gain_no_more_than_by_chance() -> None:
    records, _ = make_dataset(1, 20_000, 1000)
    observations = build_observations(records)
    assert observations.volumes.largest == pytest.approx(8e5, rel=0.1)
    ended = _gains(observations)
    print(ended)
    assert all(gain < 0.0 for gain in ended.values())
    # Were volumes taken as lognormal without an end.
    lognormal = replace(observations.volumes.population, largest=np.inf)
    volumes = bounded(replace(observations.volumes, population=lognormal, largest=np.inf), np.inf)
    endless = _gains(replace(observations, volumes=volumes))
    print(endless)
    assert endless["volume-law"] > 2.0
