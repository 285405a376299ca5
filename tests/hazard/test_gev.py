"""GEV distributions against SciPy's."""

import numpy as np
from scipy import stats

from avahazard.hazard.frequency_draws import Gev


def test_quantiles_are_exceeded_as_often_as_they_say() -> None:
    gev = Gev(np.array([-0.3, 0.1, 0.4]), np.array([8.0, 9.0, 10.0]), np.array([1.0, 0.5, 2.0]))
    for probability in (0.1, 0.5, 0.99):
        exceeded = np.diag(gev.exceedance(gev.quantile(probability)))
        np.testing.assert_allclose(exceeded, 1.0 - probability)


def test_both_are_scipys_at_any_shape_and_past_the_bounds() -> None:
    shape = np.array([-0.5, -1e-9, 0.0, 1e-9, 0.3, 0.8])
    gev = Gev(shape, np.linspace(8.0, 10.0, 6), np.linspace(0.5, 2.0, 6))
    values = np.array([-20.0, 4.0, 8.5, 9.0, 12.0, 60.0])
    expected = stats.genextreme(shape[:, None], gev.location[:, None], gev.scale[:, None])
    np.testing.assert_allclose(gev.exceedance(values), expected.sf(values), rtol=1e-9, atol=1e-15)
    assert 0.0 in gev.exceedance(values)
    assert 1.0 in gev.exceedance(values)
    for probability in (1e-3, 0.5, 0.9999):
        np.testing.assert_allclose(
            gev.quantile(probability), expected.ppf(probability)[:, 0], rtol=1e-10
        )
