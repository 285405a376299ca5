"""The likelihood of a runout length, against integration over friction."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from avahazard.inference.likelihood.panels import N_NODES
from avahazard.inference.likelihood.straight_density import (
    N_POINTS,
    REACH,
    straight_density_nodes,
    straight_points,
)

CASES = [
    (754.0, 11065.0, 10.0),
    (100.0, 50_000.0, 10.0),  # H/L = 0.002, off any table made for snow
    (800.0, 300.0, 10.0),  # H/L = 2.7
    (640.0, 1450.0, 200.0),
    (640.0, 1450.0, 700.0),
]


@pytest.mark.parametrize(("height", "length", "sigma"), CASES)
@pytest.mark.parametrize("in_log", [True, False])
@pytest.mark.parametrize("away", [0.0, 0.5])
def test_any_friction_is_told(
    height: float, length: float, sigma: float, in_log: bool, away: float
) -> None:
    """Σ w p(ν) is ∫ p(L | μ) p(ν) dν for a law that scatters about H/L, or off it."""
    place, weight = np.zeros(N_NODES), np.zeros(N_NODES)
    tail = np.zeros(2)
    log_scale, _ = straight_density_nodes(height, length, sigma, in_log, 1, place, weight, tail)
    mu = height / length * np.exp(away)
    centre, scatter = (np.log(mu), 0.3) if in_log else (mu, 0.3 * mu)
    found = np.exp(log_scale) * np.sum(weight * norm.pdf(place, centre, scatter))

    def integrand(along: float) -> float:
        nu = np.log(height / along)
        here, per = (nu, 1.0 / along) if in_log else (height / along, height / along**2)
        return float(norm.pdf(length, along, sigma) * norm.pdf(here, centre, scatter) * per)

    low = max(length - 9 * sigma, 1.0)
    expected = quad(integrand, low, length + 9 * sigma, epsabs=0, limit=500, points=[length])[0]
    assert found == pytest.approx(expected, rel=0.02 if sigma > 500 else 2e-3)


@pytest.mark.parametrize(("height", "length", "sigma"), [*CASES, (300.0, 800.0, 110.0)])
def test_sums_take_fewer_points_to_the_same_end(height: float, length: float, sigma: float) -> None:
    found = []
    for for_sums in (False, True):
        points, logs = np.empty(N_POINTS), np.empty(N_POINTS)
        n = straight_points(height, length, sigma, True, for_sums, points, logs)
        mass = np.exp(logs[:n])
        mean = np.average(points[:n], weights=mass)
        found.append([mass.sum(), mean, np.average((points[:n] - mean) ** 2, weights=mass), n])
    assert found[1][:3] == pytest.approx(found[0][:3], rel=1e-8)
    # A bump cut off at its steep end keeps its points.
    assert (found[1][3] < found[0][3]) == (length - REACH * sigma > min(height / 3.0, length / 2.0))


@pytest.mark.parametrize(("height", "length", "sigma"), CASES)
def test_beyond_all_frictions_a_block_goes_nowhere(
    height: float, length: float, sigma: float
) -> None:
    place, weight, tail = np.zeros(N_NODES), np.zeros(N_NODES), np.full(2, np.nan)
    log_scale, _ = straight_density_nodes(height, length, sigma, True, 1, place, weight, tail)
    assert tail[0] == 0.0
    # The density of this record for a length of nought.
    share = norm.pdf(length, 0.0, sigma) / np.exp(log_scale)
    assert tail[1] == (pytest.approx(share) if share > 1e-9 else 0.0)
    assert (tail[1] > 0.0) == (length < 6.0 * sigma)
