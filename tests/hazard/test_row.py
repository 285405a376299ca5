import numpy as np

from avahazard.hazard.frequency import fit_volume_frequency
from avahazard.hazard.rows import Scenario, hazard_row
from avahazard.hazard.runout_bounds import RunoutBounds
from avahazard.hazard.volume_region import VolumeRecord, region_of
from avahazard.results.hazard import Spread
from avahazard.results.volumes import ReturnLevel

BOUNDS = RunoutBounds(
    x=Spread(None, 1800.0, 1900.0, None),
    elevation=Spread(None, None, 700.0, 760.0),
    p_left_profile=0.1,
    p_not_released=0.0,
    n_draws=1000,
    n_nonpositive=3,
    x_steps=(1800.0, 1900.0, None),
)
VOLUMES = np.linspace(8.0, 11.0, 18)
RECORD = VolumeRecord(
    *("p", 1950, 1999, "the span of its records", 20, 18, 0),
    *(VOLUMES, np.zeros(18), VOLUMES, np.zeros(18)),
)


def test_row_of_a_return_period() -> None:
    volume = ReturnLevel(100.0, 5e4, 2e4, 9e4, extrapolated=True)
    frequency = fit_volume_frequency(region_of([RECORD]), "p", np.random.default_rng(0))
    row = hazard_row(Scenario("p", 5e4, 100.0, volume, frequency), BOUNDS, "friction")
    assert row.to_dict() == {
        "path_id": "p",
        "return_period_years": 100.0,
        "volume_m3": 5e4,
        "runout_x_m": {"mean": None, "q05": 1800.0, "q50": 1900.0, "q95": None},
        "runout_elevation_m": {"mean": None, "q05": None, "q50": 700.0, "q95": 760.0},
        "runout_x_steps_m": [1800.0, 1900.0, None],
        "interval": "friction",
        "p_left_profile": 0.1,
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
        "years_from": "the span of its records",
        "years_not_observed": 0,
        "events_per_year": 0.4,
        "extrapolated": True,
        "notes": [],
    }


def test_row_of_a_given_volume() -> None:
    row = hazard_row(Scenario("p", 1e4), BOUNDS, "friction")
    assert row.return_period_years is None
    assert "volume_method" not in row.to_dict()
