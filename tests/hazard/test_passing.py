"""Rates past places by curves and by kernels, against the sums that they stand for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.hazard.avalanches import Avalanches, EventVolumes, annual_rate, exceeded, one_volume
from avahazard.hazard.exceedance import _thresholds_between, descent, passing, path_ends
from avahazard.hazard.passing_kernel import MAX_NODES, share_under, summed_share
from avahazard.inference.model.specification import Specification
from avahazard.physics.runout_curve import MU
from tests.hazard.naive import naive_passing_rate
from tests.hazard.parabola import TOP_M, avalanches_of, draws

RELEASES = (TOP_M, 2350.0)
N = 6
CASES = {
    "lognormal": Specification(),
    "normal": Specification(distribution="normal"),
    "student": Specification(tails="student"),
}


def mixed(case: str, sigma: float = 0.15) -> Avalanches:
    rng = np.random.default_rng(4)
    coordinates = draws(sigma, N)
    coordinates[:, 0] += 0.1 * rng.standard_normal(N)
    coordinates[:, 2] += 0.3 * rng.standard_normal(N)
    share = rng.dirichlet(np.ones(8), N)
    share[:, 2] = 0.0
    volumes = EventVolumes(
        rng.gamma(2.0, 0.2, N), np.linspace(8.0, 12.2, 8), share / share.sum(axis=1)[:, None]
    )
    return avalanches_of(coordinates, volumes, RELEASES, specification=CASES[case])


@pytest.mark.parametrize("case", CASES)
def test_rates_past_places_are_the_sums_over_volumes(case: str) -> None:
    avalanches = mixed(case)
    x = np.linspace(*path_ends(avalanches), 40)
    naive = naive_passing_rate(avalanches)
    expected = np.array([naive(np.full(N, place)) for place in x])
    found = passing(avalanches).rates(x)
    np.testing.assert_allclose(found, expected, atol=2e-8 * avalanches.volumes.rate.max())
    assert np.ptp(expected) > 0.1


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("what", ["location", "scatter"])
@pytest.mark.parametrize("first", [0, 2])
def test_classes_that_differ_in_friction_have_rates_of_their_own(
    case: str, what: str, first: int
) -> None:
    """In all draws, or in some."""
    avalanches = mixed(case)
    own = getattr(avalanches, what).copy()
    assert own.shape[1] == 2
    own[first:, 1] += 0.1
    differ = replace(avalanches, **{what: own})
    x = np.linspace(*path_ends(differ), 40)
    naive = naive_passing_rate(differ)
    expected = np.array([naive(np.full(N, place)) for place in x])
    found = passing(differ).rates(x)
    np.testing.assert_allclose(found, expected, atol=2e-8 * differ.volumes.rate.max())
    assert np.max(np.abs(found - passing(avalanches).rates(x))) > 0.001


@pytest.mark.parametrize("case", CASES)
def test_the_place_of_a_rate_is_that_of_the_halvings(case: str) -> None:
    avalanches = mixed(case)
    places = []
    for period in (3.0, 10.0, 30.0):
        rate = annual_rate(period)
        found = passing(avalanches).exceeded(rate)
        expected = exceeded(naive_passing_rate(avalanches), rate, *path_ends(avalanches), N)
        np.testing.assert_array_equal(np.isinf(found), np.isinf(expected))
        np.testing.assert_allclose(found, expected, atol=1e-3)
        places += [x for x in found if np.isfinite(x)]
        # The curves' own rates, halved: the very same cell.
        by_curves = exceeded(
            lambda x: np.diagonal(passing(avalanches).rates(x)), rate, *path_ends(avalanches), N
        )
        np.testing.assert_array_equal(found, by_curves)
    assert len(np.unique(places)) > N


@pytest.mark.parametrize("case", CASES)
def test_a_share_is_read_within_1e_8(case: str) -> None:
    shares = descent(mixed(case)).shares
    assert shares.nodes.shape[1] == 1, "releases alone do not part frictions"
    for p in range(N):
        last = shares.low[p, 0] + (shares.n_nodes[p, 0] - 1) / shares.per_step[p, 0]
        for nu in np.linspace(shares.low[p, 0], last, 301):
            exact = summed_share(shares, p, 0, nu)
            assert share_under(shares, p, 0, nu) == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("case", CASES)
def test_what_scatters_as_usual_has_curves_of_some_nodes(case: str) -> None:
    nodes = descent(mixed(case)).shares.nodes
    assert 20 < nodes.shape[2] <= MAX_NODES


def test_curves_of_one_volume_go_as_far_as_its_friction() -> None:
    nodes = descent(avalanches_of(draws(0.02, N), one_volume(1e5, N))).shares.nodes
    # Five to each scatter, six and a half of them to each side.
    assert 66 <= nodes.shape[2] <= 67


def test_hardly_any_scatter_needs_no_curve() -> None:
    avalanches = mixed("lognormal", sigma=1e-5)
    shares = descent(avalanches).shares
    assert shares.nodes.size == 0 < MAX_NODES
    x = np.linspace(*path_ends(avalanches), 10)
    naive = naive_passing_rate(avalanches)
    expected = np.array([naive(np.full(N, place)) for place in x])
    np.testing.assert_allclose(passing(avalanches).rates(x), expected, atol=1e-8)


def test_where_no_block_leaves_every_friction_is_asked_for() -> None:
    falling = np.linspace(900.0, 100.0, len(MU))[None, None]
    assert _thresholds_between(falling) == (MU[0], MU[-1])
    falling[..., :3], falling[..., -4:] = np.inf, 100.0
    assert _thresholds_between(falling) == (MU[2], MU[-4])
