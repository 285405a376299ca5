"""How often avalanches pass places, against sums and against draws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from avahazard.effects.catalogue import definition
from avahazard.hazard.exceedance import (
    LEAST_SEEN,
    MAX_NODES,
    Avalanches,
    _thresholds_between,
    at_the_middle,
    at_volume,
    chance_seen,
    exceeded,
    exceeded_runout,
    middle_runout,
    natural_runouts,
    path_ends,
    places_passed,
    rates_past,
    reach,
    with_unseen,
)
from avahazard.hazard.exceedance_kernel import share_under, summed_share
from avahazard.hazard.extremes import (
    EventVolumes,
    annual_rate,
    event_volumes,
    one_volume,
    with_volumes,
)
from avahazard.hazard.rows import runout_interval, spread
from avahazard.inference.model.specification import Specification
from avahazard.physics.runout_curve import MU
from tests.hazard.naive import naive_exceedance_rate, rate_below
from tests.hazard.parabola import LAW, TOP_M, avalanches_of, draws, path, stop, stops, volume_bounds

VOLUME = 1e5
MEDIAN = np.exp(LAW[0] - LAW[1] * VOLUME * 1e-6)
SIGMA = 0.1


def test_one_volume_and_no_scatter_is_the_deterministic_stop_by_both_ways() -> None:
    deterministic = stop(MEDIAN)
    coordinates = draws(1e-9, 4)
    avalanches = avalanches_of(coordinates, one_volume(VOLUME, 4, rate=0.2))
    for period in (10.0, 100.0, 300.0):
        mixed = exceeded_runout(avalanches, period)
        assert mixed == pytest.approx([deterministic] * 4, abs=0.5)
    given = path(coordinates, None, at=[VOLUME])
    bounds = volume_bounds(given, VOLUME, 100, np.random.default_rng(0))
    assert (bounds.runout_x_m.q05, bounds.runout_x_m.q95) == pytest.approx(
        (deterministic,) * 2, abs=0.5
    )
    assert middle_runout(avalanches) == pytest.approx([deterministic] * 4, abs=0.5)
    assert natural_runouts(avalanches) == pytest.approx(deterministic, abs=0.5)


def test_one_volume_is_exceeded_at_its_quantile_of_friction() -> None:
    rate, period = 0.4, 50.0
    avalanches = avalanches_of(draws(SIGMA, 1), one_volume(VOLUME, 1, rate))
    share = annual_rate(period) / rate
    z = float(np.quantile(np.random.default_rng(1).standard_normal(1_000_000), share))
    expected = stop(MEDIAN * np.exp(SIGMA * z))
    assert exceeded_runout(avalanches, period) == pytest.approx([expected], abs=4.0)


def test_the_runout_is_exceeded_as_often_in_simulated_years() -> None:
    volumes = EventVolumes(np.array([0.7]), np.log([1e4, 4e4, 8e4]), np.array([[0.5, 0.4, 0.1]]))
    avalanches = avalanches_of(draws(SIGMA, 1), volumes, (TOP_M, 2350.0))
    (x,) = exceeded_runout(avalanches, 20.0)
    assert np.isfinite(x)
    rng = np.random.default_rng(5)
    n_years = 100_000
    count = rng.poisson(0.7, n_years)
    year = np.repeat(np.arange(n_years), count)
    volume = rng.choice(np.exp(volumes.log_volume), size=len(year), p=volumes.share[0])
    mu = np.exp(LAW[0] - LAW[1] * 1e-6 * volume + SIGMA * rng.standard_normal(len(year)))
    runout = np.where(rng.random(len(year)) < 0.5, stops(mu, TOP_M), stops(mu, 2350.0))
    farthest = np.zeros(n_years)
    np.maximum.at(farthest, year, runout)
    assert np.mean(farthest > x) == pytest.approx(1 / 20, abs=0.002)


def test_two_kinds_are_exceeded_as_often_in_simulated_years() -> None:
    kinds, share, shift = definition("two-kinds").build({}), 0.3, -0.3
    volumes = EventVolumes(np.array([0.7]), np.log([1e4, 8e4]), np.array([[0.6, 0.4]]))
    own = [share, shift] / np.array([p.prior_sd for p in kinds.parameters])
    avalanches = avalanches_of(draws(SIGMA, 1, *own), volumes, effects=(kinds,))
    (x,) = exceeded_runout(avalanches, 20.0)
    rng, n_years = np.random.default_rng(8), 100_000
    year = np.repeat(np.arange(n_years), rng.poisson(0.7, n_years))
    volume = np.where(rng.random(len(year)) < 0.6, 1e4, 8e4)
    of_kind = np.where(rng.random(len(year)) < share, (1.0 - share) * shift, -share * shift)
    log_mu = LAW[0] - LAW[1] * 1e-6 * volume + of_kind + SIGMA * rng.standard_normal(len(year))
    farthest = np.zeros(n_years)
    np.maximum.at(farthest, year, stops(np.exp(log_mu), TOP_M))
    assert np.isfinite(x)
    assert np.mean(farthest > x) == pytest.approx(1 / 20, abs=0.002)


def test_the_chance_of_reaching_falls_to_one_in_t_at_the_runout_of_t() -> None:
    avalanches = avalanches_of(draws(SIGMA, 2), one_volume(VOLUME, 2, 0.3))
    places, (_, chance, _) = reach(avalanches, 400)
    assert (np.diff(chance) <= 0.0).all()
    assert chance[0] == pytest.approx(-np.expm1(-0.3), rel=1e-3)
    for period in (10.0, 100.0):
        x = float(np.interp(-1 / period, -chance, places))
        assert exceeded_runout(avalanches, period)[0] == pytest.approx(x, abs=6.0)


def test_natural_and_parameters_apart() -> None:
    rng = np.random.default_rng(6)
    coordinates = draws(SIGMA, 400)
    coordinates[:, 0] += 0.05 * rng.standard_normal(400)
    avalanches = avalanches_of(coordinates, one_volume(VOLUME, 400))
    natural = spread(natural_runouts(avalanches))
    parameters = spread(middle_runout(avalanches))
    for found, sd in ((natural, SIGMA), (parameters, 0.05)):
        for z, value in ((1.645, found.q05), (0.0, found.q50), (-1.645, found.q95)):
            assert value == pytest.approx(stop(MEDIAN * np.exp(sd * z)), rel=0.03)


def test_the_middle_is_one_draw_of_medians_whose_shares_add_up() -> None:
    share = np.array([[0.7, 0.2, 0.1], [0.1, 0.7, 0.2], [0.2, 0.1, 0.7]])
    volumes = EventVolumes(np.array([0.2, 0.5, 0.3]), np.log([1e4, 4e4, 8e4]), share)
    middle = at_the_middle(avalanches_of(draws(SIGMA, 3), volumes))
    assert middle.n_parameters == 1
    assert middle.volumes.rate == pytest.approx([0.3])
    np.testing.assert_allclose(middle.volumes.share, np.full((1, 3), 1.0 / 3.0))


def test_more_rate_and_a_longer_period_go_farther() -> None:
    volumes = EventVolumes(np.array([0.05, 0.2]), np.log([VOLUME]), np.ones((2, 1)))
    avalanches = avalanches_of(draws(SIGMA, 2), volumes)
    often, seldom = exceeded_runout(avalanches, 50.0), exceeded_runout(avalanches, 500.0)
    assert often[0] < often[1] < seldom[1]
    assert often[0] < seldom[0]


def test_a_period_in_which_nothing_comes_has_the_release() -> None:
    avalanches = avalanches_of(draws(SIGMA, 1), one_volume(VOLUME, 1, rate=0.01))
    assert exceeded_runout(avalanches, 10.0) == pytest.approx(avalanches.site.release_x)


def test_beyond_the_profile() -> None:
    avalanches = avalanches_of(draws(SIGMA, 3), one_volume(2e6, 3, rate=5.0))
    x = exceeded_runout(avalanches, 300.0)
    assert np.isinf(x).all()
    found = runout_interval(avalanches, x, "what varies")
    x_m, elevation_m = found.runout_x_m, found.runout_elevation_m
    assert (x_m.q50, elevation_m.q50, x_m.mean) == (None, None, None)
    assert found.interval == "what varies"


def test_a_volume_between_the_nodes() -> None:
    nodes = EventVolumes(np.ones(2), np.linspace(9.0, 13.0, 41), np.full((2, 41), 1 / 41))
    avalanches = avalanches_of(draws(SIGMA, 2), nodes)
    exact = avalanches_of(draws(SIGMA, 2), one_volume(VOLUME, 2))
    between = at_volume(avalanches, np.full(2, np.log(VOLUME)))
    np.testing.assert_allclose(between.location, exact.location, atol=2e-4)
    np.testing.assert_allclose(at_the_middle(exact).location[0], exact.location[0])


def test_stops_that_scatter_in_metres_agree_with_the_paper_s_way() -> None:
    coordinates = draws(60.0, 50)
    given = path(coordinates, one_volume(VOLUME, 50), metres=True, at=[VOLUME])
    avalanches = given.avalanches
    natural = runout_interval(avalanches, natural_runouts(avalanches), "nature")
    bounds = volume_bounds(given, VOLUME, 40_000, np.random.default_rng(0))
    for key in ("q05", "q50", "q95"):
        assert getattr(natural.runout_elevation_m, key) == pytest.approx(
            getattr(bounds.runout_elevation_m, key), abs=3.0
        )


def test_the_friction_of_a_volume_lies_between_that_of_its_neighbours() -> None:
    volumes = EventVolumes(np.ones(3), np.log([1e4, 1e5]), np.full((3, 2), 0.5))
    mixed = avalanches_of(draws(SIGMA, 3), volumes)
    small, large = mixed.location[0, 0]
    assert small > large
    found = at_volume(mixed, np.log([1e4, 10**4.5, 1e6]))
    assert found.location[:, 0, 0] == pytest.approx([small, 0.5 * (small + large), large])
    assert found.scatter == pytest.approx(SIGMA)
    assert found.volumes.share.shape == (3, 1)


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
    naive = naive_exceedance_rate(avalanches)
    expected = np.array([naive(np.full(N, place)) for place in x])
    found = rates_past(avalanches, x)
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
    naive = naive_exceedance_rate(differ)
    expected = np.array([naive(np.full(N, place)) for place in x])
    found = rates_past(differ, x)
    np.testing.assert_allclose(found, expected, atol=2e-8 * differ.volumes.rate.max())
    assert np.max(np.abs(found - rates_past(avalanches, x))) > 0.001


@pytest.mark.parametrize("case", CASES)
def test_the_place_of_a_rate_is_that_of_the_halvings(case: str) -> None:
    avalanches = mixed(case)
    places = []
    for period in (3.0, 10.0, 30.0):
        rate = annual_rate(period)
        found = places_passed(avalanches, rate)
        expected = exceeded(naive_exceedance_rate(avalanches), rate, *path_ends(avalanches), N)
        np.testing.assert_array_equal(np.isinf(found), np.isinf(expected))
        np.testing.assert_allclose(found, expected, atol=1e-3)
        places += [x for x in found if np.isfinite(x)]
        # The curves' own rates, halved: the very same cell.
        by_curves = exceeded(
            lambda x: np.diagonal(rates_past(avalanches, x)), rate, *path_ends(avalanches), N
        )
        np.testing.assert_array_equal(found, by_curves)
    assert len(np.unique(places)) > N


@pytest.mark.parametrize("case", CASES)
def test_a_share_is_read_within_1e_8(case: str) -> None:
    shares = mixed(case).descent.shares
    assert shares.nodes.shape[1] == 1, "releases alone do not part frictions"
    for p in range(N):
        last = shares.low[p, 0] + (shares.n_nodes[p, 0] - 1) / shares.per_step[p, 0]
        for nu in np.linspace(shares.low[p, 0], last, 301):
            exact = summed_share(shares, p, 0, nu)
            assert share_under(shares, p, 0, nu) == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("case", CASES)
def test_what_scatters_as_usual_has_curves_of_some_nodes(case: str) -> None:
    nodes = mixed(case).descent.shares.nodes
    assert 20 < nodes.shape[2] <= MAX_NODES


def test_curves_of_one_volume_go_as_far_as_its_friction() -> None:
    nodes = avalanches_of(draws(0.02, N), one_volume(1e5, N)).descent.shares.nodes
    # Five to each scatter, six and a half of them to each side.
    assert 66 <= nodes.shape[2] <= 67


def test_hardly_any_scatter_needs_no_curve() -> None:
    avalanches = mixed("lognormal", sigma=1e-5)
    shares = avalanches.descent.shares
    assert shares.nodes.size == 0 < MAX_NODES
    x = np.linspace(*path_ends(avalanches), 10)
    naive = naive_exceedance_rate(avalanches)
    expected = np.array([naive(np.full(N, place)) for place in x])
    np.testing.assert_allclose(rates_past(avalanches, x), expected, atol=1e-8)


def test_where_no_block_leaves_every_friction_is_asked_for() -> None:
    falling = np.linspace(900.0, 100.0, len(MU))[None, None]
    assert _thresholds_between(falling) == (MU[0], MU[-1])
    falling[..., :3], falling[..., -4:] = np.inf, 100.0
    assert _thresholds_between(falling) == (MU[2], MU[-4])


SEEN_SIGMA, RATE, N_SEEN = 0.15, 0.8, 400_000
LOG_VOLUME = np.log([1e4, 5e4, 2e5])
SHARE = np.array([0.5, 0.3, 0.2])


def height(x: float) -> float:
    return 2500.0 - 0.9 * x + 1.2e-4 * x**2


@pytest.fixture(scope="module")
def drawn() -> tuple[np.ndarray, np.ndarray]:
    """Give volumes (as numbers of nodes) and stops x (m) of a great many avalanches."""
    rng = np.random.default_rng(7)
    k = rng.choice(3, N_SEEN, p=SHARE)
    log_mu = (
        LAW[0] - LAW[1] * np.exp(LOG_VOLUME[k]) * 1e-6 + SEEN_SIGMA * rng.standard_normal(N_SEEN)
    )
    x = np.empty(N_SEEN)
    for j, release in enumerate(RELEASES):
        selected = np.arange(N_SEEN) % 2 == j
        x[selected] = stops(np.exp(log_mu[selected]), release)
    return k, x


def on_record(k: np.ndarray, seen: np.ndarray, seen_only: bool = True) -> Avalanches:
    """The path by the rate and the volumes of what was seen."""
    share = np.bincount(k[seen], minlength=3) / np.sum(seen)
    volumes = EventVolumes(
        np.full(4, RATE * np.mean(seen)), LOG_VOLUME, np.tile(share, (4, 1)), seen_only
    )
    return avalanches_of(draws(SEEN_SIGMA, 4), volumes, RELEASES)


def test_with_the_unseen_the_rate_is_that_of_all(drawn) -> None:
    k, x = drawn
    limit = float(np.quantile(x, 0.35))
    recorded = on_record(k, x > limit)
    found = with_unseen(recorded, np.array([height(limit)]))
    np.testing.assert_allclose(found.volumes.rate, RATE, rtol=0.02)
    np.testing.assert_allclose(found.volumes.share[0], SHARE, atol=0.01)
    assert recorded.volumes.rate[0] < 0.7 * RATE
    chance = chance_seen(recorded, np.array([height(limit)]))[0]
    truth = [np.mean(x[k == j] > limit) for j in range(3)]
    np.testing.assert_allclose(chance, truth, atol=0.005)
    # The runout of 20 years is that of all avalanches, not that of those that were seen.
    share = -np.log1p(-1.0 / 20.0) / RATE
    assert exceeded_runout(found, 20.0)[0] == pytest.approx(np.quantile(x, 1.0 - share), abs=5.0)
    assert exceeded_runout(recorded, 20.0)[0] < np.quantile(x, 1.0 - share) - 5.0


def test_a_rate_of_all_avalanches_stays(drawn) -> None:
    k, x = drawn
    for seen_only, limit in ((False, 1800.0), (True, np.nan)):
        given = on_record(k, x > 0.0, seen_only)
        assert with_unseen(given, np.array([limit])) is given


def test_some_draws_may_have_a_limit_and_others_none(drawn) -> None:
    k, x = drawn
    given = on_record(k, x > 0.0)
    groups = replace(given, curves=given.curves * 2, group=np.array([0, 1, 0, 1]))
    limit = height(float(np.quantile(x[np.isfinite(x)], 0.35)))
    found = with_unseen(groups, np.array([limit, np.nan])).volumes.rate
    np.testing.assert_allclose(found[1::2], given.volumes.rate[1::2])
    assert np.all(found[::2] > 1.2 * given.volumes.rate[::2])


def test_what_is_hardly_ever_seen_does_not_blow_up(drawn) -> None:
    k, x = drawn
    given = on_record(k, x > 0.0)
    found = with_unseen(given, np.array([float(height(x[np.isfinite(x)].max()))]))
    assert np.all(found.volumes.rate <= RATE / LEAST_SEEN * 1.0001)
    assert np.isfinite(found.volumes.share).all()


def test_with_scatter_in_metres() -> None:
    volumes = EventVolumes(np.full(4, RATE), LOG_VOLUME, np.tile(SHARE, (4, 1)), True)
    known = avalanches_of(draws(60.0, 4), volumes, metres=True)
    middle = stops(np.exp(LAW[0] - LAW[1] * np.exp(LOG_VOLUME) * 1e-6), TOP_M)
    limit = float(height(middle[1]))
    assert chance_seen(known, np.array([limit]))[0, 1] == pytest.approx(0.5, abs=0.02)


def test_more_nodes_are_those_of_the_seen_too() -> None:
    volumes = EventVolumes(np.ones(2), LOG_VOLUME, np.tile(SHARE, (2, 1)), True)
    assert with_volumes(volumes, np.log([2e4])).seen_only


def test_nodes_hold_the_rate_between_their_middles() -> None:
    rate = np.array([0.5, 2.0])
    found = event_volumes(
        rate, lambda v: rate[:, None] * np.exp(-np.maximum(v - 8.0, 0.0))[None, :], 8.0, 14.0
    )
    assert found.share.sum(axis=1) == pytest.approx([1.0, 1.0])
    over = (found.share * (found.log_volume > 10.0)).sum(axis=1)
    middle = found.log_volume[found.log_volume > 10.0][0]
    step = np.diff(found.log_volume)[0]
    assert over == pytest.approx([np.exp(-(middle - step / 2 - 8.0))] * 2)


def test_one_place_has_one_node() -> None:
    found = event_volumes(np.array([0.5]), lambda v: np.empty((1, len(v))), 9.0, 9.0)
    assert (found.log_volume.tolist(), found.share.tolist()) == ([9.0], [[1.0]])


def test_more_nodes_have_no_share() -> None:
    found = with_volumes(one_volume(1e4, 2, 0.3), np.log([1e3, 1e4, 1e5]))
    np.testing.assert_allclose(np.exp(found.log_volume), [1e3, 1e4, 1e5])
    assert found.share.tolist() == [[0.0, 1.0, 0.0]] * 2


def test_where_nothing_comes_all_volumes_share_alike() -> None:
    rate = np.array([0.0, 0.4])
    found = event_volumes(rate, lambda v: np.zeros((2, len(v))), 8.0, 9.0)
    n = len(found.log_volume)
    assert found.share[0] == pytest.approx(np.full(n, 1.0 / n))
    assert found.share[1] == pytest.approx(np.eye(n)[0])


VOLUMES = EventVolumes(
    np.array([0.4, 0.2]), np.log([1e4, 1e5, 4e5]), np.array([[0.6, 0.3, 0.1], [0.2, 0.3, 0.5]])
)
RELEASE_HEIGHTS = (TOP_M, 2350.0)


def drawn_friction(p: int, n: int, rng: np.random.Generator, sigma: float) -> np.ndarray:
    volume = rng.choice(np.exp(VOLUMES.log_volume), size=n, p=VOLUMES.share[p])
    return np.exp(LAW[0] - LAW[1] * 1e-6 * volume + sigma * rng.standard_normal(n))


def test_the_rate_under_a_friction_is_that_of_drawn_avalanches() -> None:
    avalanches = avalanches_of(draws(0.1, 2), VOLUMES)
    rng = np.random.default_rng(1)
    for mu in (0.35, 0.5, 0.65):
        found = rate_below(avalanches, np.full((2, 1), mu))
        for p in range(2):
            share = np.mean(drawn_friction(p, 400_000, rng, 0.1) < mu)
            assert found[p] == pytest.approx(VOLUMES.rate[p] * share, abs=0.001)
    assert rate_below(avalanches, np.zeros((2, 1))).tolist() == [0.0, 0.0]
    assert rate_below(avalanches, np.full((2, 1), np.inf)) == pytest.approx(VOLUMES.rate)


def test_the_rate_past_a_place_is_that_of_drawn_avalanches() -> None:
    avalanches = avalanches_of(draws(0.1, 2), VOLUMES, RELEASE_HEIGHTS)
    places = np.array([2000.0, 2400.0, 2800.0])
    rates = rates_past(avalanches, places)
    rng = np.random.default_rng(2)
    for x, found in zip(places, rates, strict=True):
        for p in range(2):
            passed = []
            for z in RELEASE_HEIGHTS:
                mu = drawn_friction(p, 200_000, rng, 0.1)
                passed.append(np.mean(stops(mu, z) > x))
            assert found[p] == pytest.approx(VOLUMES.rate[p] * np.mean(passed), abs=0.001)


def test_friction_that_is_normal_is_over_nought() -> None:
    specification = Specification(distribution="normal")
    coordinates = draws(0.3, 1)
    avalanches = avalanches_of(coordinates, one_volume(1e5, 1), specification=specification)
    mean = np.exp(LAW[0] - LAW[1] * 0.1)
    truth = stats.truncnorm(-mean / 0.3, np.inf, loc=mean, scale=0.3)
    for mu in (0.0, 0.2, 0.6):
        assert rate_below(avalanches, np.full((1, 1), mu)) == pytest.approx(truth.cdf(mu))


def test_students_tails() -> None:
    avalanches = avalanches_of(
        draws(0.1, 1), one_volume(1e5, 1), specification=Specification(tails="student")
    )
    middle = np.exp(LAW[0] - LAW[1] * 0.1)
    found = rate_below(avalanches, np.full((1, 1), middle * np.exp(-0.3)))
    assert found == pytest.approx(stats.t(4).cdf(-3.0))


def test_effects_on_friction_see_the_volume_of_each_node() -> None:
    facts = {"knots": [9.0, 10.0], "centre": 10.0, "scale": 1.0}
    effect = definition("covariate:volume_m3").build(facts)
    slope = 0.1 / effect.parameters[0].prior_sd
    avalanches = avalanches_of(draws(0.1, 2, slope), VOLUMES, effects=(effect,))
    volume = np.exp(VOLUMES.log_volume)
    expected = LAW[0] - LAW[1] * 1e-6 * volume + 0.1 * (VOLUMES.log_volume - 10.0)
    np.testing.assert_allclose(avalanches.location[0, 0], expected)


def test_fewer_draws_of_the_model_serve_several_times() -> None:
    coordinates = draws(0.1, 3)
    coordinates[:, 0] += [0.0, 0.1, 0.2]
    avalanches = avalanches_of(coordinates, one_volume(1e5, 6))
    assert np.diff(avalanches.location[:, 0, 0]) == pytest.approx([0.0, 0.1, 0.0, 0.1, 0.0])


def test_the_level_of_a_rate() -> None:
    found = exceeded(lambda v: np.exp(-v), np.array([0.1, 0.01, 2.0, 1e-9]), 0.0, 10.0, 4)
    assert found[:3] == pytest.approx([np.log(10.0), np.log(100.0), 0.0], abs=1e-5)
    assert found[3] == np.inf


def test_a_year_has_one_or_more_with_chance_one_in_t() -> None:
    assert -np.expm1(-annual_rate(30.0)) == pytest.approx(1 / 30)


def test_a_level_that_is_exceeded_just_as_often_counts() -> None:
    found = exceeded(lambda v: np.where(v < 5.0, 0.1, 0.0), 0.1, 0.0, 10.0, 1)
    assert found == pytest.approx([5.0], abs=1e-5)


def test_two_kinds_pass_as_often_as_each_by_its_share() -> None:
    kinds, share, shift = definition("two-kinds").build({}), 0.3, -0.4
    volumes = EventVolumes(np.full(3, 0.3), np.log([1e4, 1e5]), np.tile([0.4, 0.6], (3, 1)))
    own = [share, shift] / np.array([p.prior_sd for p in kinds.parameters])
    u = draws(SIGMA, 3, *own)

    def of_one(added: float) -> Avalanches:
        return avalanches_of(draws(SIGMA, 3) + np.array([added, 0.0, 0.0]), volumes)

    first, second = of_one(-share * shift), of_one((1.0 - share) * shift)
    both = avalanches_of(u, volumes, effects=(kinds,))
    x = np.linspace(*path_ends(both), 9)
    for same in (
        lambda a: rates_past(a, x),
        lambda a: rates_past(at_the_middle(a), x),
        lambda a: rates_past(at_volume(a, np.log([1e4, 3e4, 1e5])), x),
        lambda a: chance_seen(a, np.array([1700.0])),
    ):
        expected = (1.0 - share) * same(first) + share * same(second)
        assert same(both) == pytest.approx(expected, abs=1e-7)
    given = path(u, None, effects=(kinds,), at=[VOLUME])
    bounds = volume_bounds(given, VOLUME, 20_000, np.random.default_rng(0))
    alone = avalanches_of(u, one_volume(VOLUME, 3), effects=(kinds,))
    low, middle, high = (places_passed(alone, level)[0] for level in (0.95, 0.5, 0.05))
    assert [bounds.runout_x_m.q05, bounds.runout_x_m.q50] == pytest.approx([low, middle], abs=12.0)
    assert (bounds.runout_x_m.q95, high) == (None, np.inf)
