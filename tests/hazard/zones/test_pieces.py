"""Zones from pressures and runouts, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.hazard.zones.entry import Exceeded, draw_densities, pressure_kpa, zone_pieces
from avahazard.hazard.zones.limits import FRENCH, SWISS, Rule, ZoneLimits, ZoneSystem

X = np.linspace(100.0, 1100.0, 41)


def flow(stop_x: float, top_kpa: float, n: int = 1) -> Exceeded:
    """Full pressure at the release, nought at the stop, straight between them."""
    pressure = np.maximum(top_kpa * (1.0 - (X - 100.0) / (stop_x - 100.0)), 0.0)
    return Exceeded(np.full(n, stop_x if stop_x <= X[-1] else np.inf), np.tile(pressure, (n, 1)))


def ends(limits: ZoneSystem, exceeded: dict[float, Exceeded]) -> list[tuple[str, float, float]]:
    return [(z.zone, z.from_x_m, z.to_x_m) for z in zone_pieces(limits, X, exceeded)]


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
    pressure = np.where(X <= 600.0, 40.0, 0.0)[None]
    found = zone_pieces(
        ZoneSystem("one", (ZoneLimits("a", "#000000", (Rule(100.0, 30.0),)),)),
        X,
        {100.0: Exceeded(np.array([610.0]), pressure)},
    )
    assert found[0].to_x_m == pytest.approx(602.5)


def test_above_a_place_in_a_zone_all_is_in_it() -> None:
    pressure = np.where((X > 300.0) & (X < 500.0), 5.0, 50.0)
    pressure = np.where(X > 900.0, 0.0, pressure)[None]
    limits = ZoneSystem("one", (ZoneLimits("a", "#000000", (Rule(100.0, 30.0),)),))
    (found,) = zone_pieces(limits, X, {100.0: Exceeded(np.array([920.0]), pressure)})
    assert 900.0 < found.to_x_m < 920.0


def test_quantiles_over_the_draws_and_beyond_the_profile() -> None:
    runout = np.linspace(400.0, 1300.0, 1000)
    runout[runout > 1100.0] = np.inf
    limits = ZoneSystem("one", (ZoneLimits("a", "#000000", (Rule(100.0),)),))
    exceeded = {100.0: Exceeded(runout, np.zeros((1000, len(X))))}
    (found,) = zone_pieces(limits, X, exceeded)
    assert (found.to_x_m, found.beyond, found.to_x_q95_m) == (
        pytest.approx(849.5, abs=1),
        False,
        None,
    )
    assert found.to_x_q05_m == pytest.approx(445.0, abs=1.0)
    far = {100.0: Exceeded(np.full(3, np.inf), np.full((3, len(X)), 50.0))}
    for rule in (Rule(100.0), Rule(100.0, 30.0)):
        (found,) = zone_pieces(ZoneSystem("one", (ZoneLimits("a", "#000000", (rule,)),)), X, far)
        assert (found.to_x_m, found.beyond, found.to_x_q05_m) == (X[-1], True, None)


def test_density_has_its_mean_and_spread() -> None:
    density = draw_densities(300.0, 50.0, 200_000, np.random.default_rng(1))
    assert (density.mean(), density.std()) == (
        pytest.approx(300.0, rel=0.002),
        pytest.approx(50.0, rel=0.01),
    )
    assert draw_densities(250.0, 0.0, 3, np.random.default_rng(1)) == pytest.approx([250.0] * 3)
    speed = np.array([[[10.0, 0.0]]])
    assert pressure_kpa(np.array([300.0]), speed)[0, 0].tolist() == [30.0, 0.0]


def test_french_red_begins_at_thirty_kilopascals() -> None:
    # 30 kPa of 100 are left at 70 % of the way.
    found = ends(FRENCH, {100.0: flow(500.0, 100.0), 300.0: flow(700.0, 100.0)})
    assert found[0] == ("red", 100.0, pytest.approx(100.0 + 0.7 * 400.0))
