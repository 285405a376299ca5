import numpy as np
import pytest

from avahazard.hazard.avalanches import annual_rate
from avahazard.hazard.frequency import return_volume, table_frequency

ROWS = [(10.0, 2e4), (100.0, 2e5), (300.0, 5e5)]


def test_the_rows_come_back_and_the_line_between_them_is_straight_in_logs() -> None:
    frequency = table_frequency("p", ROWS)
    for years, volume in ROWS:
        found = return_volume(frequency, years)
        assert found.volume_m3 == pytest.approx(volume)
        assert found.q05_m3 == found.q95_m3 == pytest.approx(volume)
        assert not found.extrapolated
    between = np.log(return_volume(frequency, 30.0).volume_m3)
    share = np.log(annual_rate(10.0) / annual_rate(30.0)) / np.log(
        annual_rate(10.0) / annual_rate(100.0)
    )
    assert between == pytest.approx(np.log(2e4) + share * np.log(10.0))


@pytest.mark.parametrize("years", [5.0, 301.0])
def test_past_the_ends_is_marked(years: float) -> None:
    assert return_volume(table_frequency("p", ROWS), years).extrapolated


def test_rates_over_volumes_are_those_of_the_periods() -> None:
    draws = table_frequency("p", ROWS).draws
    for years in (10.0, 50.0, 100.0, 1000.0):
        volume = draws.log_volume(1.0 / years)
        assert draws.rate_over(volume[:1])[0, 0] == pytest.approx(annual_rate(years))
    assert draws.rate_over(np.array([5.0]))[0, 0] == pytest.approx(annual_rate(10.0))
    assert draws.rate == pytest.approx(annual_rate(10.0))
    low, high = draws.ends()
    assert low == pytest.approx(np.log(2e4))
    assert high > np.log(5e5)


def test_one_row_is_one_volume() -> None:
    frequency = table_frequency("p", [(30.0, 1e5)])
    volumes = frequency.volumes()
    assert np.exp(volumes.log_volume) == pytest.approx([1e5])
    assert volumes.share.tolist()[0] == [1.0]
    assert volumes.rate == pytest.approx(annual_rate(30.0))
    assert return_volume(frequency, 100.0).volume_m3 == pytest.approx(1e5)
    assert return_volume(frequency, 100.0).extrapolated
    assert frequency.draws.rate_over(np.log([9e4, 1.1e5]))[0] == pytest.approx(
        [annual_rate(30.0), 0.0]
    )
