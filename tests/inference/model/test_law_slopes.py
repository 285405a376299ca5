"""Derivatives of the laws against differences."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.model.law_curves import MOST_LOG
from avahazard.inference.model.laws import LAWS, law

V = np.array([1.0, 1e3, 2e4, 1.5e5, 1.2e6])


@pytest.mark.parametrize("name", LAWS)
def test_they_are_what_differences_go_to(name: str) -> None:
    item = law(name)
    rng = np.random.default_rng(1)
    for u in rng.normal(item.prior_mean, item.prior_sd, (20, len(item.coordinates))):
        steps = 1e-5 * np.eye(len(u))
        apart = [item.log_friction(u + d, V) - item.log_friction(u - d, V) for d in steps]
        np.testing.assert_allclose(item.slopes(u, V), np.array(apart) / 2e-5, atol=1e-8, rtol=1e-6)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_at_its_bounds_goes_nowhere(name: str) -> None:
    item = law(name)
    far = item.prior_mean.copy()
    far[0] = 3.0 * MOST_LOG
    assert np.all(item.slopes(far, np.array([1.0, 1e300])) == 0.0)
