"""What is natural and what is not known, apart."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.hazard.avalanches import EventVolumes
from avahazard.hazard.frequency import VolumeFrequency
from avahazard.hazard.frequency_draws import Gev, GevDraws
from avahazard.hazard.rows import Scenario, annual_reach, uncertainties
from tests.hazard.parabola import draws, path

N = 40


def frequency() -> VolumeFrequency:
    """Volumes of a period about which the draws differ."""
    location = np.log(5e4) + np.linspace(-0.5, 0.5, N)
    gev = Gev(np.full(N, 0.1), location, np.full(N, 0.3))
    return VolumeFrequency("p", GevDraws(np.full(N, 0.4), gev), "a test", pooled=False)


def volumes() -> EventVolumes:
    return EventVolumes(np.full(N, 0.3), np.linspace(8.0, 13.5, 24), np.full((N, 24), 1.0 / 24.0))


def test_a_volume_that_is_not_known_adds_to_the_parameters_alone() -> None:
    given = path(draws(0.1, N), volumes())
    known = uncertainties(given, Scenario("p", 1e5, 100.0))
    unknown = uncertainties(given, Scenario("p", 1e5, 100.0, frequency=frequency()))
    # All draws of friction are equal, so that with the volume all is known but chance.
    assert known.parameters.runout_x_m.q05 == pytest.approx(known.parameters.runout_x_m.q95)
    assert unknown.parameters.runout_x_m.q95 - unknown.parameters.runout_x_m.q05 > 20.0
    assert unknown.natural == known.natural
    assert known.natural.runout_x_m.q95 - known.natural.runout_x_m.q05 > 100.0
    # Without a period there is no volume to be asked for.
    alone = uncertainties(given, Scenario("p", 1e5, None, frequency=frequency()))
    assert alone.parameters.runout_x_m == known.parameters.runout_x_m


def test_the_chance_to_be_reached_falls_along_the_path() -> None:
    found = annual_reach(path(draws(0.1, N), volumes()))
    low, middle, high = found.p_per_year.q05, found.p_per_year.q50, found.p_per_year.q95
    assert len(found.x_m) == len(found.elevation_m) == len(middle)
    assert np.all(np.diff(middle) <= 0.0)
    assert np.all(np.array(low) <= np.array(middle))
    assert np.all(np.array(middle) <= np.array(high))
