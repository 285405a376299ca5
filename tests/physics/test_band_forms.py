import numpy as np
import pytest

from avahazard.physics.band_forms import WIDTH, band_forms


def whole(band: np.ndarray) -> np.ndarray:
    """The symmetric matrix of upper diagonals `[3, n]`."""
    n = band.shape[1]
    upper = sum((np.diag(band[2 - k, k:], k) for k in range(min(3, n))), np.zeros((n, n)))
    return upper + np.triu(upper, 1).T


@pytest.mark.parametrize("n", [1, 2, 3, 8, 40])
@pytest.mark.parametrize("n_shares", [1, WIDTH, WIDTH + 3])
def test_the_forms_of_bands_are_those_of_whole_matrices(n: int, n_shares: int) -> None:
    rng = np.random.default_rng(n)
    errors, ground = rng.uniform(-1.0, 1.0, (2, 3, n))
    for band in (errors, ground):
        band[1, 0] = 0.0
        band[0, :2] = 0.0
        band[2] += 5.0
    z = rng.standard_normal(n)
    share = rng.uniform(0.0, 3.0, n_shares)
    found = band_forms(errors, ground, z, share)
    assert found.shape == (2, n_shares)
    for (determinant, square), s in zip(found.T, share, strict=True):
        matrix = whole(errors + s * ground)
        assert determinant == pytest.approx(np.linalg.slogdet(matrix)[1])
        assert square == pytest.approx(z @ np.linalg.solve(matrix, z))


def test_what_is_not_positive_is_told() -> None:
    errors, ground = np.zeros((2, 3, 9))
    errors[2], ground[2, 4] = 1.0, -1.0
    found = band_forms(errors, ground, np.ones(9), np.array([0.0, 0.5, 1.5]))
    assert found[0] == pytest.approx([0.0, np.log(0.5), np.inf])
    assert found[1] == pytest.approx([9.0, 10.0, 0.0])
