"""Records whose errors are as large as the path: the likelihood, and what is learnt from it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.model.specification import Specification
from avahazard.inference.sampling import sample
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU
from tests.workflow.twin import twin_study

FAR = np.linspace(-12.0, 8.0, 200_001)
"""Log frictions from where every block leaves to where none is released."""


@pytest.mark.parametrize("error_m", [100.0, 300.0, 1000.0, 10_000.0])
@pytest.mark.parametrize(
    ("log_a", "scatter"), [(-0.65, 0.023), (-0.65, 0.15), (-2.5, 0.1), (1.2, 0.4)]
)
def test_a_vague_record_has_its_marginal_likelihood(
    error_m: float, log_a: float, scatter: float
) -> None:
    """Against a sum over twelve decades of friction, those beyond the tables among them."""
    study = twin_study("scey")
    study = replace(study, sigma=np.full(study.n_events, error_m))
    model = assemble(study, Specification(law="constant"), {})
    found = model.event_log_likelihood(np.array([log_a, np.log(scatter)]))
    tables = model.nodes.predicted_at(np.zeros(2))
    density = stats.norm.pdf(FAR, log_a, scatter) * (FAR[1] - FAR[0])
    cell = np.clip(np.searchsorted(np.log(MU), FAR) - 1, 0, len(MU) - 2)
    for i in range(study.n_events):
        left = tables.status[i] == LEFT_PROFILE
        gone = (left[:-1] & left[1:])[cell] | (left[0] & (np.log(MU[0]) > FAR))
        stop = np.interp(FAR, np.log(MU), tables.record[i])
        there = np.where(gone, 0.0, stats.norm.pdf(study.observed[i], stop, error_m))
        slow = float(np.sum(there * density))
        if slow * error_m > 1e-6:
            assert found[i] == pytest.approx(np.log(slow), abs=0.01)


@pytest.mark.parametrize("law", [pytest.param("exponential", marks=pytest.mark.slow), "constant"])
def test_larger_errors_never_narrow_the_posterior(law: str) -> None:
    """The same records with larger errors have less information on friction and its scatter."""
    study = twin_study("scey")
    widths = []
    for error_m in (10.0, 300.0, 1000.0, 10_000.0):
        vague = replace(study, sigma=np.full(study.n_events, error_m))
        drawn = sample(assemble(vague, Specification(law=law), {}), n_chains=2, n_draws=400, seed=4)
        widths.append(drawn.draws.std(axis=0))
    # Beyond some error nothing is left to be lost; the widths are those of draws.
    for narrow, wide in pairwise(widths):
        assert np.all(wide > 0.85 * narrow)
    assert np.all(widths[-1] > 2.0 * widths[0])
