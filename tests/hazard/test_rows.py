"""The rows of one path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.hazard.exceedance import exceeded_runout
from avahazard.hazard.extremes import EventVolumes, Gev, GevDraws, one_volume
from avahazard.hazard.frequency import VolumeFrequency, fit_volume_frequency
from avahazard.hazard.path_hazard import PathHazard, RecordedStops
from avahazard.hazard.rows import (
    Scenario,
    Weighted,
    annual_reach,
    design_of,
    elevation_quantiles,
    hazard_row,
    place_quantiles,
    row_notes,
    uncertainties,
)
from avahazard.hazard.volume_records import VolumeRecord, region_of
from avahazard.inference.model.specification import Specification
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Profile
from avahazard.results.hazard import Design, FarthestRecord, MapPoint, PlaceQuantiles, ReturnLevel
from tests.hazard.parabola import draws, path, path_rows, stop

N_LEFT, N_FAR, N_NEAR = 100, 797, 100
STOPS = (
    np.repeat([1800.0, 1900.0, np.inf], [N_NEAR, N_FAR, N_LEFT]),
    np.repeat([760.0, 700.0, -np.inf], [N_NEAR, N_FAR, N_LEFT]),
)
"""Of 1000 draws, of which three cannot be."""
VOLUMES = np.linspace(8.0, 11.0, 18)
RECORD = VolumeRecord(
    *("p", 1950, 1999, "the first to the last record of any path", 20, 18, 0),
    *(VOLUMES, np.zeros(18), VOLUMES, np.zeros(18)),
)


def test_row_of_a_return_period() -> None:
    volume = ReturnLevel(100.0, 5e4, 2e4, 9e4, extrapolated=True)
    frequency = fit_volume_frequency(region_of([RECORD]), "p", np.random.default_rng(0))
    row = hazard_row(Scenario("p", 5e4, 100.0, volume, frequency), *STOPS, 0, 1000, "friction")
    assert row.to_dict() == {
        "path_id": "p",
        "return_period_years": 100.0,
        "volume_m3": 5e4,
        "runout_x_m": {"mean": None, "q05": 1800.0, "q50": 1900.0, "q95": None},
        "runout_elevation_m": {"mean": None, "q05": None, "q50": 700.0, "q95": 760.0},
        "runout_x_steps_m": [1800.0] * 2 + [1900.0] * 15 + [None] * 2,
        "interval": "friction",
        "p_left_profile": N_LEFT / 997,
        "p_not_released": 0.0,
        "n_draws": 1000,
        "n_nonpositive_friction": 3,
        "volume_interval_m3": {"q05": 2e4, "q95": 9e4},
        "volume_method": frequency.method,
        "volume_source": "records",
        "pooled": False,
        "n_records": 20,
        "first_year": 1950,
        "last_year": 1999,
        "years_from": "the first to the last record of any path",
        "years_not_observed": 0,
        "events_per_year": 0.4,
        "extrapolated": True,
        "notes": [],
    }


@pytest.mark.parametrize(("beyond", "said"), [(0, False), (2, False), (4, True)])
def test_more_records_past_a_median_than_its_period_allows_are_noted(
    beyond: int, said: bool
) -> None:
    """Once in 100 years in 50: half a record is expected, and four come once in 600 times."""
    volume = ReturnLevel(100.0, 5e4, 2e4, 9e4, extrapolated=False)
    frequency = fit_volume_frequency(region_of([RECORD]), "p", np.random.default_rng(0))
    row = hazard_row(Scenario("p", 5e4, 100.0, volume, frequency), *STOPS, 0, 1000, "friction")
    given = path(draws(1e-6, 30), one_volume(1e5, 30, rate=0.5))
    design = replace(design_of(given, np.full(9, 1500.0)), records_beyond=beyond, n_records=20)
    notes = row_notes(given, replace(row, design=design))
    told = [str(note) for note in notes if note.key == "many_beyond"]
    assert bool(told) == said
    if said:
        assert told[0].startswith("4 of its 20 records lie past the 100-year median, 0.5 are")


def test_row_of_a_given_volume() -> None:
    row = hazard_row(Scenario("p", 1e4), *STOPS, 0, 1000, "friction")
    assert row.return_period_years is None
    assert "volume_method" not in row.to_dict()


PERIODS = (3.0, 10.0, 29.0, 30.0, 100.0, 300.0, 1000.0)


def of(given: PathHazard, period: float) -> Design:
    return design_of(given, exceeded_runout(given.avalanches, period))


def random_world(seed: int) -> tuple[np.ndarray, EventVolumes, Specification]:
    """Draws of a law that may fall or rise with volume, and draws of rate and volumes."""
    rng = np.random.default_rng(seed)
    n, n_volumes = 60, 7
    normal = seed % 3 == 0
    a = 0.45 * np.exp(0.2 * rng.standard_normal(n))
    n_law = rng.normal(rng.uniform(-3.0, 3.0), 2.0, n)
    scatter = rng.uniform(0.02, 0.3, n) * (0.5 if normal else 1.0)
    share = rng.dirichlet(np.ones(n_volumes), n)
    volumes = EventVolumes(
        rng.uniform(0.01, 2.0) * np.exp(0.3 * rng.standard_normal(n)),
        np.linspace(np.log(1e3), np.log(rng.uniform(2e4, 5e5)), n_volumes),
        share,
    )
    specification = Specification(
        distribution="normal" if normal else "lognormal",
        tails="student" if seed % 4 == 1 else "normal",
    )
    return np.column_stack([np.log(a), n_law, np.log(scatter)]), volumes, specification


def far(x: float | None) -> float:
    return np.inf if x is None else x


@pytest.mark.parametrize("seed", range(40))
def test_it_rises_with_the_return_period_whatever_the_law(seed: int) -> None:
    coordinates, volumes, specification = random_world(seed)
    given = path(coordinates, volumes, (2450.0, 2300.0), specification)
    found = np.array([exceeded_runout(given.avalanches, period) for period in PERIODS])
    assert (found[1:] >= found[:-1]).all()  # draw by draw
    designs = [of(given, period) for period in PERIODS]
    for key in ("q05", "q50", "q95"):
        x = [far(getattr(d.runout_x_m, key)) for d in designs]
        assert (np.diff([v for v in x if np.isfinite(v)]) >= 0.0).all()
        assert x == sorted(x)
    assert np.all(np.diff([d.p_beyond for d in designs]) >= 0.0)


def test_it_rises_where_the_runout_of_the_volume_falls() -> None:
    """Friction that rises with volume, and the issue's two answers."""
    n = 40
    coordinates = draws(0.1, n)
    coordinates[:, :2] = np.log(0.55), -1.0  # larger avalanches stop earlier
    nodes = np.log([1e4, 5e4, 2e5])
    given = path(coordinates, EventVolumes(np.full(n, 0.5), nodes, np.full((n, 3), 1 / 3)))
    volumes = [
        path_rows(
            path(coordinates, one_volume(volume, n), at=[volume]), [Scenario("p", volume)], 500, 0
        )[0].runout_x_m.q50
        for volume in (1e4, 5e4, 2e5)
    ]
    assert volumes == sorted(volumes, reverse=True)
    assert of(given, 300.0).runout_x_m.q50 > of(given, 30.0).runout_x_m.q50 + 20.0


def test_quantiles_are_those_of_the_draws_never_of_those_that_stopped() -> None:
    x = np.array([*np.arange(1000.0, 1060.0), *[np.inf] * 40])
    found = place_quantiles(x)
    assert (found.q05, found.q50, found.q95) == (1004.0, 1049.0, None)
    smooth = smooth_profile(np.arange(0.0, 3001.0, 30.0), 2000.0 - 0.5 * np.arange(0.0, 3001.0, 30))
    z = elevation_quantiles(smooth, x)
    # Falling ground: each is the elevation at the mirrored quantile of x.
    assert z.q05 is None
    assert z.q50 == pytest.approx(float(smooth.height(1049.0)))
    assert z.q95 == pytest.approx(float(smooth.height(1004.0)))


def test_elevations_on_a_counter_slope_have_quantiles_of_their_own() -> None:
    ground = np.arange(0.0, 3001.0, 30.0)
    smooth = smooth_profile(ground, 2000.0 - 0.8 * ground + 2e-4 * ground**2)
    lowest = float(ground[np.argmin(smooth.height(ground))])
    x = np.linspace(lowest - 300.0, lowest + 500.0, 81)
    found = elevation_quantiles(smooth, x)
    heights = np.sort(smooth.height(x))
    assert (found.q05, found.q50, found.q95) == pytest.approx(
        (heights[4], heights[40], heights[76]), abs=0.5
    )
    assert found.q05 > float(smooth.height(lowest)) - 1e-6


def test_the_records_and_the_map_beside_it() -> None:
    n = 30
    given = path(draws(1e-6, n), one_volume(1e5, n, rate=0.5))
    middle = stop(np.exp(np.log(0.7) - 0.2))
    assert of(given, 100.0).farthest_record is None
    assert of(given, 100.0).point is None
    along = np.array([0.0, 3600.0])
    recorded = RecordedStops(
        np.array([middle - 50.0, middle + 20.0, middle + 40.0]),
        ("1950", "1960-01-02", None),
        Profile("P", along, -along, lon=np.array([7.0, 7.36]), lat=np.array([46.0, 46.0])),
    )
    found = of(replace(given, recorded=recorded), 100.0)
    assert found.runout_x_m.q50 == pytest.approx(middle, abs=0.5)
    assert (found.records_beyond, found.n_records) == (2, 3)
    assert found.farthest_record == FarthestRecord(middle + 40.0, None)
    assert isinstance(found.point, MapPoint)
    assert found.point.x == pytest.approx(7.0 + 1e-4 * found.runout_x_m.q50)
    left = RecordedStops(np.array([np.inf, middle]), ("1970", "1980"))
    found = of(replace(given, recorded=left), 100.0)
    assert (found.records_beyond, found.farthest_record) == (1, FarthestRecord(None, "1970"))


def test_beyond_the_profile_nothing_is_counted() -> None:
    given = path(draws(0.1, 3), one_volume(2e6, 3, rate=5.0))
    along = np.array([0.0, 9e3])
    line = Profile("P", along, -along, easting_m=along, northing_m=along, crs="X")
    recorded = RecordedStops(np.array([1500.0]), ("1970",), line)
    found = of(replace(given, recorded=recorded), 300.0)
    assert found.runout_x_m == found.runout_elevation_m == PlaceQuantiles(None, None, None)
    assert (found.p_beyond, found.point, found.records_beyond) == (1.0, None, None)


def test_what_is_asked_for_besides_changes_nothing() -> None:
    coordinates, volumes, _ = random_world(3)
    alone = of(path(coordinates, volumes), 100.0)
    among = of(path(coordinates, volumes, at=[3e3, 7e4]), 100.0)
    assert among.runout_x_m.q50 == pytest.approx(alone.runout_x_m.q50, abs=1e-3)


N = 40


def frequency() -> VolumeFrequency:
    """Volumes of a period about which the draws differ."""
    location = np.log(5e4) + np.linspace(-0.5, 0.5, N)
    gev = Gev(np.full(N, 0.1), location, np.full(N, 0.3))
    return VolumeFrequency("p", GevDraws(np.full(N, 0.4), gev), "a test", False, (0.0, 80.0))


def volumes() -> EventVolumes:
    return EventVolumes(np.full(N, 0.3), np.linspace(8.0, 13.5, 24), np.full((N, 24), 1.0 / 24.0))


def test_a_volume_that_is_not_known_adds_to_the_parameters_alone() -> None:
    given = path(draws(0.1, N), volumes())
    natural, known = uncertainties(given, Scenario("p", 1e5, 100.0))
    same, unknown = uncertainties(given, Scenario("p", 1e5, 100.0, frequency=frequency()))
    # All draws of friction are equal, so that with the volume all is known but chance.
    assert known.runout_x_m.q05 == pytest.approx(known.runout_x_m.q95)
    assert unknown.runout_x_m.q95 - unknown.runout_x_m.q05 > 20.0
    assert same == natural
    assert natural.runout_x_m.q95 - natural.runout_x_m.q05 > 100.0
    # Without a period there is no volume to be asked for.
    _, alone = uncertainties(given, Scenario("p", 1e5, None, frequency=frequency()))
    assert alone.runout_x_m == known.runout_x_m


def test_the_chance_to_be_reached_falls_along_the_path() -> None:
    found = annual_reach([Weighted("m", 1.0, path(draws(0.1, N), volumes()))])
    low, middle, high = found.p_per_year.q05, found.p_per_year.q50, found.p_per_year.q95
    assert len(found.x_m) == len(found.elevation_m) == len(middle)
    assert np.all(np.diff(middle) <= 0.0)
    assert np.all(np.array(low) <= np.array(middle))
    assert np.all(np.array(middle) <= np.array(high))
