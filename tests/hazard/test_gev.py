import numpy as np
import pytest
from scipy import stats

from avahazard.hazard.gev import Gev, gev_from_l_moments, l_moments


def naive_l_moments(sample: np.ndarray) -> list[float]:
    """From probability-weighted moments, term by term (Hosking 1990)."""
    ordered = sorted(sample)
    n = len(ordered)
    b0 = sum(ordered) / n
    b1 = sum(i * x for i, x in enumerate(ordered)) / (n * (n - 1))
    b2 = sum(i * (i - 1) * x for i, x in enumerate(ordered)) / (n * (n - 1) * (n - 2))
    return [b0, 2 * b1 - b0, 6 * b2 - 6 * b1 + b0]


def test_l_moments_equal_the_twin() -> None:
    samples = np.random.default_rng(1).lognormal(size=(5, 17))
    found = np.array(l_moments(samples))
    np.testing.assert_allclose(found, np.array([naive_l_moments(s) for s in samples]).T)


@pytest.mark.parametrize("shape", [-0.3, -0.1, 0.0, 0.1, 0.3])
def test_a_large_sample_gives_its_parameters_back(shape: float) -> None:
    sample = Gev(shape, 8.0, 1.3).sample((200_000,), np.random.default_rng(2))
    fit = gev_from_l_moments(*l_moments(sample))
    assert (fit.shape, fit.location, fit.scale) == pytest.approx((shape, 8.0, 1.3), abs=0.02)


def test_gumbel_has_shape_zero_and_the_right_moments() -> None:
    second = 0.7
    fit = gev_from_l_moments(5.0, second, 0.4, gumbel=True)
    assert fit.shape == 0
    assert stats.gumbel_r.mean(fit.location, fit.scale) == pytest.approx(5.0)
    assert fit.scale * np.log(2) == pytest.approx(second)


def test_shapes_around_zero_join_smoothly() -> None:
    ratio = 2 / (np.log(2) / np.log(3)) - 3  # of a Gumbel distribution, shape 0
    scales = [gev_from_l_moments(0.0, 1.0, ratio + d).scale for d in (-1e-5, 0.0, 1e-5)]
    assert scales == pytest.approx([1 / np.log(2)] * 3, abs=1e-4)
