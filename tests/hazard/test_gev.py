import numpy as np

from avahazard.hazard.gev import Gev


def test_quantiles_are_exceeded_as_often_as_they_say() -> None:
    gev = Gev(np.array([-0.3, 0.1, 0.4]), np.array([8.0, 9.0, 10.0]), np.array([1.0, 0.5, 2.0]))
    for probability in (0.1, 0.5, 0.99):
        exceeded = np.diag(gev.exceedance(gev.quantile(probability)))
        np.testing.assert_allclose(exceeded, 1.0 - probability)
