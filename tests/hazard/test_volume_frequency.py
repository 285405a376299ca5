import numpy as np
import pytest

from avahazard.hazard.gev import Gev
from avahazard.hazard.volume_frequency import fit_volume_frequency, return_volume
from avahazard.hazard.volume_record import VolumeRecord
from avahazard.records.errors import AvahazardError

TRUTH = Gev(0.1, 9.0, 1.2)
CHANCE = 0.3


def record(path_id: str, log_maxima: np.ndarray, n_years: int) -> VolumeRecord:
    n = len(log_maxima)
    return VolumeRecord(path_id, 2001 - n_years, 2000, "a test", n, n, 0, np.asarray(log_maxima))


def world(path_id: str, n_years: int, rng: np.random.Generator, shift: float = 0) -> VolumeRecord:
    """Years with an event by chance, the largest volume of each from TRUTH."""
    n = int(np.count_nonzero(rng.random(n_years) < CHANCE))
    return record(path_id, TRUTH.sample((n,), rng) + shift, n_years)


def true_log_volume(period: float) -> float:
    """By simulation of years, without the formula under test."""
    rng = np.random.default_rng(99)
    years = TRUTH.sample((2_000_000,), rng)
    years[rng.random(len(years)) >= CHANCE] = -np.inf
    return float(np.partition(years, -int(len(years) / period))[-int(len(years) / period)])


@pytest.mark.parametrize("period", [10.0, 100.0])
def test_volumes_come_back_on_average(period: float) -> None:
    rng = np.random.default_rng(3)
    found = [
        np.log(
            return_volume(fit_volume_frequency("p", [world("p", 120, rng)]), period, rng).volume_m3
        )
        for _ in range(100)
    ]
    error = np.std(found) / len(found) ** 0.5
    assert error < 0.1
    assert np.mean(found) == pytest.approx(true_log_volume(period), abs=3 * error)


def test_a_short_record_borrows_scale_and_shape_and_says_so() -> None:
    rng = np.random.default_rng(4)
    found = []
    for _ in range(60):
        records = [world("short", 30, rng, shift=-2)]
        records += [world(f"p{i}", 100, rng, shift=i) for i in range(5)]
        fit = fit_volume_frequency("short", records)
        assert fit.pooled
        assert "pooled over 6 paths" in fit.method
        found.append(np.log(return_volume(fit, 100, rng).volume_m3))
    error = np.std(found) / len(found) ** 0.5
    assert error < 0.15
    assert np.mean(found) == pytest.approx(true_log_volume(100) - 2, abs=3 * error)


def test_a_long_record_stands_alone() -> None:
    rng = np.random.default_rng(5)
    records = [world("p", 120, rng), world("q", 120, rng, shift=5)]
    fit = fit_volume_frequency("p", records)
    assert not fit.pooled
    assert fit.gev == fit_volume_frequency("p", records[:1]).gev


def test_too_few_in_all_have_no_shape() -> None:
    fit = fit_volume_frequency("p", [record("p", np.array([7.0, 8.0, 8.2, 9.9]), 50)])
    assert fit.gev.shape == 0
    assert "(shape 0)" in fit.method
    assert return_volume(fit, 100, np.random.default_rng(0)).volume_m3 > np.exp(9)


def test_interval_holds_the_estimate_and_narrows_with_data() -> None:
    rng = np.random.default_rng(6)
    widths = []
    for n_years in (80, 800):
        found = return_volume(fit_volume_frequency("p", [world("p", n_years, rng)]), 100, rng)
        assert found.q05_m3 < found.volume_m3 < found.q95_m3
        widths.append(np.log(found.q95_m3 / found.q05_m3))
    assert widths[1] < widths[0] / 2


def test_the_same_seed_gives_the_same_interval() -> None:
    fit = fit_volume_frequency("p", [world("p", 100, np.random.default_rng(7))])
    assert return_volume(fit, 30, np.random.default_rng(1)) == return_volume(
        fit, 30, np.random.default_rng(1)
    )


@pytest.mark.parametrize(("period", "extrapolated"), [(200.0, False), (201.0, True)])
def test_extrapolation_starts_at_twice_the_record(period: float, extrapolated: bool) -> None:
    rng = np.random.default_rng(8)
    fit = fit_volume_frequency("p", [world("p", 100, rng)])
    assert return_volume(fit, period, rng).extrapolated is extrapolated


def test_events_rarer_than_the_period() -> None:
    fit = fit_volume_frequency("p", [record("p", np.arange(20.0), 100)])
    with pytest.raises(AvahazardError, match="20 of 100 years") as error:
        return_volume(fit, 5, np.random.default_rng(0))
    assert "over 5 years" in error.value.hint


@pytest.mark.parametrize(
    ("log_maxima", "message"),
    [([], "No dated event"), ([8.0, 9.0], "Too few"), ([8.0] * 16, "equal")],
)
def test_records_that_carry_no_fit(log_maxima: list[float], message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        fit_volume_frequency("p", [record("p", np.array(log_maxima), 100)])


@pytest.mark.slow
@pytest.mark.parametrize("n_years", [60, 150])
def test_coverage_of_the_interval(n_years: int) -> None:
    """Nominal 90 %; with 18 and 45 maxima somewhat less is known of such intervals."""
    rng = np.random.default_rng(10)
    truth = true_log_volume(100)
    covered = []
    while len(covered) < 600:
        drawn = world("p", n_years, rng)
        if len(drawn.log_maxima) < 15:
            continue
        found = return_volume(fit_volume_frequency("p", [drawn]), 100, rng)
        covered.append(np.log(found.q05_m3) < truth < np.log(found.q95_m3))
    assert 0.83 < np.mean(covered) < 0.95
