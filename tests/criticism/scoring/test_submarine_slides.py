"""Slides of the sea floor: H/L down to 0.002, volumes over seven decades, end to end."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from avahazard.inference.likelihood.nodes import build_nodes
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import build_observations
from avahazard.records.reading import read_records
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import import_files
from avahazard.workflow.requests import CalibrateRequest


@pytest.fixture
def events(shared_data: Path) -> Path:
    """Give the file of the slides."""
    return shared_data / "submarine-slides" / "events.csv"


def test_every_slide_tells_its_own_friction(events: Path) -> None:
    """Errors of 10 m on kilometres: ∫ p(L | μ) p(ν) dν is p(ν = log H/L) / L to a per cent."""
    observations = build_observations(read_records([events]))
    nodes = build_nodes(observations, predict_records(observations, (), {}))
    ratio = observations.fall_height / observations.observed
    assert ratio.min() < 0.003
    centre, scatter = np.log(0.05), 0.8
    density = np.sum(nodes.weight * norm.pdf(nodes.place, centre, scatter), axis=1)
    found = np.log(density) + nodes.log_scale
    expected = norm.logpdf(np.log(ratio), centre, scatter) - np.log(observations.observed)
    far = observations.observed > 500.0
    assert far.sum() > 500
    np.testing.assert_allclose(found[far], expected[far], atol=0.01)


@pytest.mark.slow
def test_the_scores_of_the_power_law_are_sane(events: Path, database: str) -> None:
    import_files(database, [events])
    calibrate(database, "base", CalibrateRequest(law="power", chains=2, draws=400, seed=1))
    found = compare(database, "base")
    n = found.scores.runout.n
    assert n == 558
    assert found.scores.elpd_loo > -11.0 * n
    assert found.held_out.elpd_loo > -11.0 * n
    assert 0.85 < found.held_out.runout.coverage_90 < 0.95


@pytest.mark.slow
def test_the_exponential_law_converges_on_them(events: Path, database: str) -> None:
    import_files(database, [events])
    found = calibrate(
        database, "base", CalibrateRequest(law="exponential", chains=2, draws=400, seed=1)
    )
    assert found.diagnostics.rhat_max < 1.05
    for parameter in found.parameters.values():
        assert np.isfinite([parameter.mean, parameter.sd, parameter.mode]).all()
    # A friction that falls over volumes up to 1e12 m3 does so by less than 1e-9 a cubic metre.
    assert abs(found.parameters["n"].mode) < 1e-9
