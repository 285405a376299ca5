"""That true volumes end somewhere is no missing effect, in however large a region."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.diagnosis.refits import refit, without_groups
from avahazard.criticism.screening.screen import gains_by_chance
from avahazard.criticism.screening.screen import tested_model as model_of
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.model.volumes import bounded
from avahazard.synth.making import make_world

KEYS = ("volume-law", "cohesion")


def _gains(observations: Observations, n_worlds: int) -> np.ndarray:
    """Gains of the `KEYS` on the records, which come first, and on worlds without an effect."""
    fit = refit(observations, Specification(), {}, ("path-effect",))
    bare, u, spreads = without_groups(fit, observations, ())
    tested = model_of(bare, u, spreads, [find_definition(k) for k in KEYS], records_alone=False)
    looked = gains_by_chance(tested, 0, range(-1, n_worlds), lambda _share: None, n_worlds)
    return np.array([each.of_candidates for each in looked])


@pytest.mark.slow
def test_of_20_000_events_other_laws_gain_no_more_than_by_chance() -> None:
    records, _ = make_world(1, 20_000, 1000)
    observations = build_observations(records)
    assert observations.volumes.largest == pytest.approx(8e5, rel=0.1)
    ended = _gains(observations, 4)
    print(np.round(ended, 2))
    assert np.all(ended[0] <= np.maximum(ended[1:].max(axis=0), 2.0))
    # Were volumes taken as lognormal without an end.
    lognormal = replace(observations.volumes.population, largest=np.inf)
    volumes = bounded(replace(observations.volumes, population=lognormal, largest=np.inf), np.inf)
    endless = _gains(replace(observations, volumes=volumes), 4)
    print(np.round(endless, 2))
    assert endless[0, 0] > endless[1:, 0].max() + 4.0
