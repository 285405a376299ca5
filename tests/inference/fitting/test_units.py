"""The exponential law over seven decades of volume."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.fitting.evidence import log_evidence
from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.fitting.units import units
from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Records
from avahazard.records.event import Event

N_TRUE = 2e-11


def slides(low: float, high: float, n_true: float, n: int = 150) -> Posterior:
    """Runouts H/μ without a profile, μ = 0.1 exp(-n V), log volumes uniform."""
    rng = np.random.default_rng(5)
    volume = np.exp(rng.uniform(np.log(low), np.log(high), n))
    mu = 0.1 * np.exp(-n_true * volume + 0.3 * rng.standard_normal(n))
    events = tuple(
        Event(
            f"s{i}",
            fall_height_m=500.0,
            runout_length_m=500.0 / float(mu[i]),
            runout_sigma_m=50.0,
            volume_m3=float(volume[i]),
            volume_rel_sigma=0.05,
        )
        for i in range(n)
    )
    return assemble(build_observations(Records(events=events)), Specification(), {})


def test_the_law_is_found_over_seven_decades() -> None:
    posterior = slides(1e4, 1e11, N_TRUE)
    mode = find_mode(posterior)
    natural = posterior.layout.readable(mode.u)
    sd = np.sqrt(np.diag(mode.covariance))
    assert float(natural["a"][0]) == pytest.approx(0.1, rel=0.15)
    assert float(natural["n"][0]) == pytest.approx(N_TRUE, rel=0.15)
    assert 0.0 < sd[1] * 1e-6 < 0.1 * N_TRUE
    found = log_evidence(posterior, mode)
    assert np.isfinite(found.value)
    assert found.error < 0.15


def test_they_are_one_on_paths_of_snow() -> None:
    assert np.array_equal(units(slides(1e4, 1e6, 1e-6)), np.ones(3))
    assert units(slides(1e4, 1e11, N_TRUE))[1] < 1e-3
