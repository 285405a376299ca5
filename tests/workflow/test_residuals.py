"""What the residuals of the paper's figure 6d are, in a synthetic dataset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.workflow.friction import standardised_residuals
from tests.workflow.test_friction import SIGMA, world


@pytest.mark.parametrize("offset", [0.0, 0.15])
def test_residuals_of_a_true_model_are_its_scatter(offset: float) -> None:
    """With drag at work and a path of its own, both taken off."""
    model, mu = world(offset)
    off, of = standardised_residuals(model)
    volume = np.exp(model.observations.columns.log_volume)
    truth = (np.log(mu) - np.log(0.5) + 1e-6 * volume) / SIGMA
    assert of == "log μ"
    assert off == pytest.approx(truth, abs=0.05)
    assert off.std() == pytest.approx(1.0, abs=0.12)


def test_by_metropolis_they_are_of_the_stop() -> None:
    model, _ = world()
    sigma = 40.0
    draws = model.draws.copy()
    draws[:, model.posterior.layout.scatter] = np.log(sigma)
    off, of = standardised_residuals(replace(model, draws=draws, method="metropolis"))
    assert of == "elevation"
    # The scatter of friction, 0.1 on its log, as one of elevation: F' times it.
    stop = np.array(list(model.observations.observed))
    height = model.observations.sites[0].smooth.height(stop)
    assert 0.5 * height.std() < sigma * off.std() < height.std()
