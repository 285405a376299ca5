"""What one path has by its avalanches."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.hazard.exceedance import exceeded_runout
from avahazard.hazard.extremes import EventVolumes, annual_rate, one_volume
from avahazard.hazard.zones import (
    N_PLACES,
    PRESETS,
    Exceeded,
    ZoneSystem,
    _behind,
    _notes,
    draw_densities,
    exceeded_speeds,
    path_zones,
    read_limits,
    zone_pieces,
)
from avahazard.inference.model.specification import Specification
from avahazard.records.errors import AvahazardError
from avahazard.results.hazard import Density, ZonedPath
from tests.hazard.parabola import draws, path
from tests.hazard.zones_parabola import (
    RATES,
    SHARES,
    VOLUMES,
    X,
    avalanches_of,
    block_speeds,
    observations,
    one,
)

SWISS, FRENCH, AUSTRIAN = (PRESETS[name] for name in ("swiss", "french", "austrian"))

RATE = 0.2


@pytest.fixture(scope="module")
def zoned() -> ZonedPath:
    """Zones where the record is long enough for 100 years, and too short for 300."""
    given = path(draws(0.1, 4), one_volume(1e5, 4, RATE))
    return path_zones(given, FRENCH, (100.0, 300.0), Density(300.0, 0.0), {300.0}, seed=0)


def test_periods_that_the_record_is_too_short_for_are_told(zoned: ZonedPath) -> None:
    assert [design.extrapolated for design in zoned.designs] == [False, True]
    for place in zoned.places:
        assert [here.extrapolated for here in place.by_return_period] == [False, True]
    (note,) = zoned.notes
    assert note.startswith("p: T = 300 is past")
    assert [zone.extrapolated for zone in zoned.zones] == [False, False, True]


def test_places_go_from_the_release_to_the_end(zoned: ZonedPath) -> None:
    places = zoned.places
    assert len(places) == N_PLACES
    assert (places[0].x_m, places[-1].x_m) == (zoned.release_x_m, zoned.end_x_m)
    chance = np.array([place.p_reach_per_year for place in places])
    assert chance[1] == pytest.approx(-np.expm1(-RATE), rel=1e-3)
    assert (np.diff(chance) <= 0.0).all()
    assert zoned.p_not_released == pytest.approx(0.0, abs=1e-3)


def test_pressure_is_that_of_the_speed_and_rarer_means_more(zoned: ZonedPath) -> None:
    for place in zoned.places:
        often, rarely = place.by_return_period
        assert often.speed_m_s.q50 <= rarely.speed_m_s.q50
        for here in (often, rarely):
            assert here.pressure_kpa.q50 == pytest.approx(0.3 * here.speed_m_s.q50**2)
    assert zoned.designs[0].design.runout_x_m.q50 < zoned.designs[1].design.runout_x_m.q50
    assert zoned.zones[1].to_x_m == pytest.approx(zoned.designs[0].design.runout_x_m.q50)


def test_avalanches_that_stay_at_their_release_are_told() -> None:
    few, many = _notes("p", 0.01, []), _notes("p", 0.4, [30.0, 100.0])
    assert few == ()
    far, held = many
    assert far.startswith("p: T = 30, 100 ")
    assert held.startswith("p: 40% ")


def test_one_volume_without_scatter_is_the_run_of_the_block() -> None:
    alone = avalanches_of(one(1e-12), one_volume(1e5, 3))
    (found,) = exceeded_speeds(alone, X, [100.0])
    expected = block_speeds(0.7 * np.exp(-0.2))[0]
    assert found == pytest.approx(np.tile(expected, (3, 1)), rel=1e-3, abs=0.15)
    assert found.max() > 30.0


def test_what_comes_too_seldom_has_no_speed() -> None:
    # Once in 50 years at most.
    rare = avalanches_of(one(0.1), one_volume(1e5, 3, rate=0.02))
    thirty, hundred = exceeded_speeds(rare, X, [30.0, 100.0])
    assert thirty.max() == 0.0
    assert hundred.max() > 20.0


def naive_speeds(p: int, sigma: float, period: float, releases: tuple[float, ...]) -> np.ndarray:
    """Draw p of the mixture counted out: every friction of many, run from every release."""
    z = (np.arange(4000) + 0.5) / 4000
    from scipy.stats import norm  # noqa: PLC0415 (slow)

    speeds, weights = [], []
    for release in releases:
        for volume, share in zip(np.exp(VOLUMES), SHARES[p], strict=True):
            mu = 0.7 * np.exp(-2e-6 * volume) * np.exp(sigma * norm.ppf(z))
            speeds.append(block_speeds(mu, release))
            weights.append(np.full(len(z), RATES[p] * share / len(releases) / len(z)))
    all_speeds, weight = np.concatenate(speeds), np.concatenate(weights)
    result = np.zeros(len(X))
    for i in range(len(X)):
        order = np.argsort(-all_speeds[:, i])
        often = np.cumsum(weight[order]) >= annual_rate(period)
        if often.any():
            result[i] = all_speeds[order[np.argmax(often)], i]
    return result


@pytest.mark.parametrize("releases", [(2450.0,), (2450.0, 2300.0, 1900.0)])
def test_mixture_of_volumes_and_releases_by_counting(releases: tuple[float, ...]) -> None:
    mixed = avalanches_of(one(0.15, 2), EventVolumes(RATES, VOLUMES, SHARES), releases)
    found = exceeded_speeds(mixed, X, [10.0, 100.0])
    for t, period in enumerate((10.0, 100.0)):
        for p in (0, 1):
            expected = naive_speeds(p, 0.15, period, releases)
            assert found[t, p] == pytest.approx(expected, rel=0.01, abs=0.4)


@pytest.mark.parametrize(
    "specification",
    [Specification(), Specification(tails="student"), Specification(distribution="normal")],
)
def test_speed_ends_where_the_runout_is_exceeded(specification: Specification) -> None:
    mixed = avalanches_of(
        one(0.12, 2), EventVolumes(RATES, VOLUMES, SHARES), specification=specification
    )
    (found,) = exceeded_speeds(mixed, X, [4.0])
    runout = exceeded_runout(mixed, 4.0)
    for p in (0, 1):
        moving = X[found[p] > 0.0]
        assert moving[-1] <= runout[p] + 1.0
        assert min(runout[p], X[-1]) < moving[-1] + 60.0
    assert X[0] < runout[0] < X[-1]


def test_drag_slows_the_draws_that_have_it() -> None:
    effect = definition("turbulent-drag").build({})
    scale = effect.parameters[0].prior_sd
    draws = np.vstack([one(1e-12, 2, 0.0), one(1e-12, 2, 0.002 / scale)])
    (found,) = exceeded_speeds(
        avalanches_of(draws, one_volume(1e5, 4), effects=(effect,)), X, [100.0]
    )
    assert found[0] == pytest.approx(block_speeds(0.7 * np.exp(-0.2))[0], rel=1e-3, abs=0.15)
    assert found[3].max() < 0.8 * found[0].max()


def test_the_front_brings_the_speed_of_the_block_behind_it() -> None:
    effect = definition("leading-edge").build({})
    share = 0.5 / effect.parameters[0].prior_sd
    draws = one(1e-12, 3, share)
    found = exceeded_speeds(
        avalanches_of(draws, one_volume(1e5, 3), effects=(effect,), length=200.0), X, [100.0]
    )[0, 0]
    site = observations(2450.0).sites[0]
    s = np.interp(X, site.terrain.x, site.terrain.s)
    behind = np.interp(s - 100.0, site.terrain.s, site.terrain.x)
    expected = np.sqrt(np.interp(behind, X, block_speeds(0.7 * np.exp(-0.2))[0] ** 2))
    moving = (behind > 100.0) & (expected > 8.0)
    assert found[moving] == pytest.approx(expected[moving], abs=0.5)


@pytest.mark.parametrize("distance", [0.0, 1.0, 40.0])
def test_what_is_behind_is_so_far_along_the_path(distance: float) -> None:
    (site,) = observations(2450.0).sites
    x = np.linspace(200.0, 2000.0, 7)
    behind = _behind(site, x, distance)
    terrain = site.terrain
    found = np.interp(x, terrain.x, terrain.s) - np.interp(behind, terrain.x, terrain.s)
    np.testing.assert_allclose(found, distance, atol=1e-9)
    # Above the top it goes on.
    assert _behind(site, np.array([terrain.x[0]]), 30.0) == pytest.approx(terrain.x[0] - 30.0)


GOOD = """
[[zone]]
name = "red"
color = "#C8102E"
[[zone.rule]]
return_period_years = 300
pressure_kpa_min = 30
[[zone.rule]]
return_period_years = 30.0

[[zone]]
name = "blue"
color = "#0072b2"
rule = [{ return_period_years = 300 }]
"""


def told(limits: ZoneSystem) -> dict[str, list[tuple[float, float]]]:
    return {
        zone.name: [(rule.return_period_years, rule.pressure_kpa_min) for rule in zone.rules]
        for zone in limits.zones
    }


def zone(*rules: tuple[float, float]) -> ZoneSystem:
    """One zone by rules of return period and least pressure."""
    names = ("return_period_years", "pressure_kpa_min")
    rule = [dict(zip(names, values, strict=True)) for values in rules]
    zones = [{"name": "a", "color": "#000000", "rule": rule}]
    return ZoneSystem.model_validate({"name": "one", "zone": zones})


def test_the_zones_of_a_file() -> None:
    found = read_limits("own.toml", GOOD)
    assert found.name == "own.toml"
    assert [(zone.name, zone.color) for zone in found.zones] == [
        ("red", "#c8102e"),
        ("blue", "#0072b2"),
    ]
    assert told(found) == {"red": [(300.0, 30.0), (30.0, 0.0)], "blue": [(300.0, 0.0)]}


def test_the_example_of_the_documentation() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "zones.md").read_text(encoding="utf-8")
    text = page.split('```toml title="valley.toml"\n')[1].split("```")[0]
    found = read_limits("valley.toml", text)
    assert [len(zone.rules) for zone in found.zones] == [2, 1]


def test_the_return_periods_of_limits() -> None:
    assert SWISS.return_periods == (30.0, 300.0)
    assert FRENCH.return_periods == (100.0, 300.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[[zone]]\n", "[[zone\n", "own.toml is not a TOML file"),
        (GOOD, "", "own.toml, zone: Field required"),
        (GOOD, "zone = []", "own.toml, zone: List should have at least 1 item"),
        (
            "return_period_years = 300\n",
            "return_period_years = 1\n",
            r"own.toml, zone 1, rule 1, return_period_years: Input should be greater than 1",
        ),
        (
            "pressure_kpa_min = 30",
            'pressure_kpa_min = "30"',
            r"zone 1, rule 1, pressure_kpa_min: Input should be a valid number \(given: '30'\)",
        ),
        ("pressure_kpa_min = 30", "pressure_kpa_min = -1", "pressure_kpa_min: .* \\(given: -1\\)"),
        ("pressure_kpa_min", "presure_kpa_min", "zone 1, rule 1, presure_kpa_min: there is no"),
        ("return_period_years = 30.0", "pressure_kpa_min = 3", "rule 2, return_period_years: F"),
        ('color = "#0072b2"', 'color = "blue"', "zone 2, color: String should match pattern"),
        ("rule = [{ return_period_years = 300 }]", "rule = []", "zone 2, rule: List should have"),
        ('name = "blue"', 'name = "red"', "own.toml has two zones 'red'"),
    ],
)
def test_one_message_that_says_where(old: str, new: str, message: str) -> None:
    with pytest.raises(AvahazardError, match=message) as caught:
        read_limits("own.toml", GOOD.replace(old, new, 1))
    assert caught.value.hint


def test_the_limits_of_two_countries() -> None:
    assert told(SWISS) == {"red": [(300.0, 30.0), (30.0, 0.0)], "blue": [(300.0, 0.0)]}
    assert told(FRENCH) == {
        "red": [(100.0, 30.0)],
        "blue": [(100.0, 0.0)],
        "yellow": [(300.0, 0.0)],
    }


PLACES_X = np.linspace(100.0, 1100.0, 41)


def flow(stop_x: float, top_kpa: float, n: int = 1) -> Exceeded:
    """Full pressure at the release, zero at the stop, straight between them."""
    pressure = np.maximum(top_kpa * (1.0 - (PLACES_X - 100.0) / (stop_x - 100.0)), 0.0)
    return Exceeded(
        np.full(n, stop_x if stop_x <= PLACES_X[-1] else np.inf), np.tile(pressure, (n, 1))
    )


def ends(limits: ZoneSystem, exceeded: dict[float, Exceeded]) -> list[tuple[str, float, float]]:
    return [(z.zone, z.from_x_m, z.to_x_m) for z in zone_pieces(limits, PLACES_X, exceeded)]


def test_swiss_zones() -> None:
    # 30 kPa of 100 are left at 70 % of the way, 880 - 100 = 780 m long.
    long, short = flow(880.0, 100.0), flow(333.0, 10.0)
    assert ends(SWISS, {30.0: short, 300.0: long}) == [
        ("red", 100.0, pytest.approx(100.0 + 0.7 * 780.0)),
        ("blue", pytest.approx(100.0 + 0.7 * 780.0), 880.0),
    ]
    # Whatever comes once in 30 years is red, be it ever so weak.
    weak = flow(750.0, 10.0)
    assert ends(SWISS, {30.0: weak, 300.0: long})[0] == ("red", 100.0, 750.0)


def test_french_zones_and_one_that_is_empty() -> None:
    weak = flow(500.0, 20.0)
    assert ends(FRENCH, {100.0: weak, 300.0: flow(700.0, 100.0)}) == [
        ("red", 100.0, 100.0),
        ("blue", 100.0, 500.0),
        ("yellow", 500.0, 700.0),
    ]


def test_pressure_ends_at_the_runout_not_at_the_next_place() -> None:
    # 40 kPa up to the place before the stop, 10 m on.
    pressure = np.where(PLACES_X <= 600.0, 40.0, 0.0)[None]
    found = zone_pieces(
        zone((100.0, 30.0)), PLACES_X, {100.0: Exceeded(np.array([610.0]), pressure)}
    )
    assert found[0].to_x_m == pytest.approx(602.5)


def test_above_a_place_in_a_zone_all_is_in_it() -> None:
    pressure = np.where((PLACES_X > 300.0) & (PLACES_X < 500.0), 5.0, 50.0)
    pressure = np.where(PLACES_X > 900.0, 0.0, pressure)[None]
    limits = zone((100.0, 30.0))
    (found,) = zone_pieces(limits, PLACES_X, {100.0: Exceeded(np.array([920.0]), pressure)})
    assert 900.0 < found.to_x_m < 920.0


def test_quantiles_over_the_draws_and_beyond_the_profile() -> None:
    runout = np.linspace(400.0, 1300.0, 1000)
    runout[runout > 1100.0] = np.inf
    limits = zone((100.0, 0.0))
    exceeded = {100.0: Exceeded(runout, np.zeros((1000, len(PLACES_X))))}
    (found,) = zone_pieces(limits, PLACES_X, exceeded)
    assert (found.to_x_m, found.beyond, found.to_x_q95_m) == (
        pytest.approx(849.5, abs=1),
        False,
        None,
    )
    assert found.to_x_q05_m == pytest.approx(445.0, abs=1.0)
    far = {100.0: Exceeded(np.full(3, np.inf), np.full((3, len(PLACES_X)), 50.0))}
    for rule in ((100.0, 0.0), (100.0, 30.0)):
        (found,) = zone_pieces(zone(rule), PLACES_X, far)
        assert (found.to_x_m, found.beyond, found.to_x_q05_m) == (PLACES_X[-1], True, None)


def test_density_has_its_mean_and_spread() -> None:
    density = draw_densities(300.0, 50.0, 200_000, np.random.default_rng(1))
    assert (density.mean(), density.std()) == (
        pytest.approx(300.0, rel=0.002),
        pytest.approx(50.0, rel=0.01),
    )
    assert draw_densities(250.0, 0.0, 3, np.random.default_rng(1)) == pytest.approx([250.0] * 3)


def test_french_red_begins_at_thirty_kilopascals() -> None:
    # 30 kPa of 100 are left at 70 % of the way.
    found = ends(FRENCH, {100.0: flow(500.0, 100.0), 300.0: flow(700.0, 100.0)})
    assert found[0] == ("red", 100.0, pytest.approx(100.0 + 0.7 * 400.0))


def test_austrian_zones_end_where_the_design_event_presses_no_more() -> None:
    # 10 kPa of 100 are left at 90 % of the way, 1 kPa at 99 %.
    red, yellow = ends(AUSTRIAN, {150.0: flow(500.0, 100.0)})
    assert red == ("red", 100.0, pytest.approx(100.0 + 0.9 * 400.0))
    assert yellow[:2] == ("yellow", pytest.approx(100.0 + 0.9 * 400.0))
    assert yellow[2] == pytest.approx(100.0 + 0.99 * 400.0, abs=2.0)
