"""What one path has by its avalanches."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.hazard.avalanches import one_volume
from avahazard.hazard.zones.entry import N_PLACES, _notes, path_zones
from avahazard.hazard.zones.limits import FRENCH
from avahazard.results.zones import Density, ZonedPath
from tests.hazard.parabola import draws, path

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
