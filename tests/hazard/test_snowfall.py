import numpy as np
import pytest
from scipy import stats

from avahazard.hazard.frequency import return_volume, snowfall_frequency
from avahazard.hazard.volume_region import VolumeRecord
from avahazard.records.errors import AvahazardError

DEPTH = stats.genextreme(0.05, 0.8, 0.25)
AREA, RATIO = 12_000.0, 0.5


def record(n_events: int, n_years: int) -> VolumeRecord:
    none = np.empty(0)
    return VolumeRecord(
        "p", 2001 - n_years, 2000, "", n_events, n_events, 0, none, none, none, none
    )


def test_the_depth_of_the_period_times_area_and_density() -> None:
    rng = np.random.default_rng(1)
    depths = DEPTH.rvs(300, random_state=rng)
    frequency = snowfall_frequency("p", depths, AREA, RATIO, None, rng)
    for years in (10.0, 100.0):
        found = return_volume(frequency, years)
        assert found.q05_m3 < found.volume_m3 < found.q95_m3
        truth = float(DEPTH.ppf(1.0 - 1.0 / years)) * AREA * RATIO
        assert found.volume_m3 == pytest.approx(truth, rel=0.08)
    assert "300 winters" in frequency.method
    assert "one avalanche a year, for want of a record" in frequency.method
    assert not return_volume(frequency, 600.0).extrapolated
    assert return_volume(frequency, 601.0).extrapolated


def test_volumes_come_as_often_as_depths_but_no_oftener_than_avalanches() -> None:
    rng = np.random.default_rng(2)
    depths = DEPTH.rvs(200, random_state=rng)
    frequency = snowfall_frequency("p", depths, AREA, RATIO, record(20, 100), rng)
    draws = frequency.draws
    volume = draws.log_volume(0.01)
    assert np.diag(draws.rate_over(volume)) == pytest.approx(-np.log1p(-0.01))
    assert draws.rate_over(np.array([0.0]))[:, 0] == pytest.approx(draws.rate)
    assert np.mean(draws.rate) == pytest.approx(0.205, rel=0.05)
    volumes = frequency.volumes()
    assert volumes.share.sum(axis=1) == pytest.approx(1.0)
    # The commonest fifth of winters' avalanches are those of much snow.
    small = (volumes.share * (np.exp(volumes.log_volume) < 0.9 * AREA * RATIO)).sum(axis=1)
    assert np.mean(small) < 0.2


@pytest.mark.parametrize("depths", [np.linspace(0.5, 1.0, 9), np.full(20, 0.7)])
def test_too_few_winters(depths: np.ndarray) -> None:
    with pytest.raises(AvahazardError, match="too few for path p") as error:
        snowfall_frequency("p", depths, AREA, RATIO, None, np.random.default_rng(0))
    assert "10 winters" in error.value.hint
