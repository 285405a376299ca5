"""Frequencies of volumes, from whatever source."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest
from scipy import stats

from avahazard.hazard.extremes import ThresholdDraws, annual_rate, gev_likelihood, over_locations
from avahazard.hazard.frequency import (
    Frequencies,
    ReturnLevel,
    VolumeFrequency,
    fit_volume_frequency,
    read_return_volumes,
    return_volume,
    table_frequency,
    volume_frequencies,
)
from avahazard.hazard.trend import fit_trend
from avahazard.hazard.volume_records import VolumeRecord, dated_volumes, region_of
from avahazard.hazard.volume_source import Family, VolumeSource
from avahazard.records.collection import Event, Path
from avahazard.records.errors import AvahazardError, RejectedRows

Write = Callable[[str, str], FilePath]
TRUTH = stats.genextreme(0.1, 9.0, 1.2)
CHANCE = 0.3


def record(path_id: str, log_maxima: np.ndarray, n_years: int) -> VolumeRecord:
    n = len(log_maxima)
    values, exact = np.asarray(log_maxima, float), np.zeros(n)
    return VolumeRecord(
        path_id, 2001 - n_years, 2000, "a test", n, n, 0, values, exact, values, exact
    )


def world(path_id: str, n_years: int, rng: np.random.Generator, shift: float = 0) -> VolumeRecord:
    """Years with an event by chance, the largest volume of each from TRUTH."""
    n = int(np.count_nonzero(rng.random(n_years) < CHANCE))
    return record(path_id, TRUTH.rvs(n, random_state=rng) + shift, n_years)


def fitted(
    records: list[VolumeRecord], rng: np.random.Generator, family: Family = "gev"
) -> VolumeFrequency:
    """The fit of the first of the records."""
    return fit_volume_frequency(region_of(records, family), records[0].path_id, rng)


def returned(
    records: list[VolumeRecord], rng: np.random.Generator, period: float = 100.0
) -> ReturnLevel:
    return return_volume(fitted(records, rng), period)


def true_log_volume(period: float) -> float:
    """By simulation of years, without the formula under test."""
    rng = np.random.default_rng(99)
    years = TRUTH.rvs(2_000_000, random_state=rng)
    years[rng.random(len(years)) >= CHANCE] = -np.inf
    return float(np.partition(years, -int(len(years) / period))[-int(len(years) / period)])


@pytest.mark.parametrize("family", ["gev", "gpd"])
@pytest.mark.parametrize("period", [10.0, 100.0])
def test_volumes_come_back_on_average(period: float, family: Family) -> None:
    rng = np.random.default_rng(3)
    found = []
    for _ in range(16):
        fit = fitted([world("p", 300, rng)], rng, family)
        found.append(np.log(return_volume(fit, period).volume_m3))
    error = np.std(found) / len(found) ** 0.5
    assert error < 0.15
    # These datasets have one event a year at most, which the Pareto takes for a Poisson process.
    slack = 0.03 if family == "gev" else 0.1
    assert np.mean(found) == pytest.approx(true_log_volume(period), abs=3 * error + slack)


def test_a_short_record_leans_on_the_others_and_says_so() -> None:
    rng = np.random.default_rng(4)
    found, alone = [], []
    for _ in range(8):
        records = [world("short", 30, rng, shift=-2)]
        records += [world(f"p{i}", 100, rng, shift=i) for i in range(5)]
        fit = fitted(records, rng)
        assert fit.pooled
        assert "with a prior from 5 other paths" in fit.method
        found.append(np.log(return_volume(fit, 100).volume_m3))
        alone.append(np.log(returned(records[:1], rng).volume_m3))
    error = np.std(found) / len(found) ** 0.5
    assert np.mean(found) == pytest.approx(true_log_volume(100) - 2, abs=3 * error)
    assert np.std(found) < np.std(alone)


def test_a_long_record_stands_alone() -> None:
    rng = np.random.default_rng(5)
    records = [world("p", 120, rng), world("q", 120, rng, shift=5)]
    fit = fitted(records, np.random.default_rng(1))
    assert not fit.pooled
    alone = fitted(records[:1], np.random.default_rng(1))
    np.testing.assert_array_equal(fit.draws.log_volume(0.01), alone.draws.log_volume(0.01))


def test_few_in_all_lean_on_the_prior_of_the_shape() -> None:
    rng = np.random.default_rng(0)
    found = returned([record("p", np.array([7.0, 8.0, 8.2, 9.9]), 50)], rng)
    assert found.volume_m3 > np.exp(9)
    assert found.q95_m3 / found.q05_m3 > 5


def test_interval_holds_the_estimate_and_narrows_with_data() -> None:
    rng = np.random.default_rng(6)
    widths = []
    for n_years in (80, 800):
        found = returned([world("p", n_years, rng)], rng)
        assert found.q05_m3 < found.volume_m3 < found.q95_m3
        widths.append(np.log(found.q95_m3 / found.q05_m3))
    assert widths[1] < widths[0] / 2


@pytest.mark.parametrize(("period", "extrapolated"), [(200.0, False), (201.0, True)])
def test_extrapolation_starts_at_twice_the_record(period: float, extrapolated: bool) -> None:
    rng = np.random.default_rng(8)
    assert returned([world("p", 100, rng)], rng, period).extrapolated is extrapolated


def test_events_rarer_than_the_period() -> None:
    with pytest.raises(AvahazardError, match="20 of 100 years") as error:
        returned([record("p", np.arange(20.0), 100)], np.random.default_rng(0), 5.0)
    assert "over 5 years" in error.value.hint


@pytest.mark.parametrize(
    ("log_maxima", "message"),
    [([], "No dated event"), ([8.0, 9.0], "Too few"), ([8.0] * 16, "equal")],
)
def test_records_that_carry_no_fit(log_maxima: list[float], message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        fitted([record("p", np.array(log_maxima), 100)], np.random.default_rng(0))


def test_a_given_threshold() -> None:
    rng = np.random.default_rng(11)
    known = world("p", 300, rng)
    region = region_of([known], "gpd", float(np.exp(10.0)))
    fit = fit_volume_frequency(region, "p", rng)
    n = int(np.sum(known.log_volumes > 10.0))
    assert f"over 22000 m3 (given), {n} excesses" in fit.method
    with pytest.raises(AvahazardError, match="no volume over the threshold"):
        fit_volume_frequency(region_of([known], "gpd", 1e9), "p", rng)
    assert region_of([known], "gpd", 0.5).threshold_m3 == 0.5


def test_the_largest_record_of_a_year_owes_it_to_its_error_too() -> None:
    rng = np.random.default_rng(6)
    years, error = 300, 0.7
    true = rng.normal(9.0, 1.0, (years, 4))
    told = true + error * rng.standard_normal(true.shape)
    maxima, sigma = told.max(axis=1), np.full(4 * years, error)
    known = VolumeRecord(
        *("p", 1701, 2000, "a test", 4 * years, years, 0),
        *(maxima, sigma[:years], told.ravel(), sigma),
    )
    draws = fitted([known], rng).draws
    for period in (2.0, 20.0):
        exact = np.quantile(true.max(axis=1), 1.0 - 1.0 / period)
        recorded = np.quantile(maxima, 1.0 - 1.0 / period)
        found = float(np.mean(draws.log_volume(1.0 / period)))
        assert recorded - exact > 0.2
        assert abs(found - exact) < 0.5 * (recorded - exact)


@pytest.mark.slow
@pytest.mark.parametrize("n_years", [60, 150])
@pytest.mark.parametrize("family", ["gev", "gpd"])
def test_coverage_of_the_interval(n_years: int, family: Family) -> None:
    """Nominal 90 %, with about 18 and 45 maxima."""
    rng = np.random.default_rng(10)
    truth = true_log_volume(100)
    covered = []
    while len(covered) < 400:
        drawn = world("p", n_years, rng)
        if len(drawn.log_maxima) < 15:
            continue
        found = return_volume(fitted([drawn], rng, family), 100)
        covered.append(np.log(found.q05_m3) < truth < np.log(found.q95_m3))
    assert 0.86 < np.mean(covered) < 0.97


def test_the_others_are_all_but_the_path() -> None:
    """What other paths say is the sum over them, however it is come by."""
    rng = np.random.default_rng(8)
    records = [
        record(f"P{k}", TRUTH.rvs(n, random_state=rng), 60) for k, n in enumerate((12, 5, 3, 2, 25))
    ]
    region = region_of(records)
    for path_id in ("P1", "P3"):
        told = [k for k in region.records if k != path_id and len(region.sample(k)) >= 3]
        expected = np.sum([over_locations(gev_likelihood(region.sample(k))) for k in told], axis=0)
        found = region.others(path_id, region.likelihood(path_id))
        assert (found.n_paths, found.n_values) == (
            len(told),
            sum(len(region.sample(k)) for k in told),
        )
        near = expected > expected.max() - 100.0
        np.testing.assert_allclose(found.likelihood[near], expected[near], rtol=1e-9)
        assert np.all(found.likelihood[~near] < expected.max() - 99.0)


def test_what_lies_at_the_threshold_is_not_over_it() -> None:
    known = record("p", np.array([9.0, 10.0, 11.5]), 30)
    assert region_of([known], "gpd").sample("p") == pytest.approx([1.5])
    assert region_of([known], "gpd", float(np.exp(9.0))).sample("p") == pytest.approx([1.0, 2.5])


def test_a_year_has_avalanches_by_jeffreys_rule() -> None:
    rng = np.random.default_rng(5)
    known = record("p", TRUTH.rvs(9, random_state=rng), 30)
    draws = fitted([known], rng).draws
    # Beta(9 + 1/2, 21 + 1/2).
    assert np.mean(draws.chance) == pytest.approx(9.5 / 31.0, abs=0.01)
    assert np.var(draws.chance) == pytest.approx(9.5 * 21.5 / (31.0**2 * 32.0), rel=0.15)


def test_volumes_of_records_are_those_that_were_seen() -> None:
    rng = np.random.default_rng(5)
    fit = fitted([record("p", TRUTH.rvs(9, random_state=rng), 30)], rng)
    assert fit.source == "records"
    assert fit.volumes().seen_only
    assert not replace(fit, record=None).volumes().seen_only


def test_maxima_never_spread_more_than_all_volumes() -> None:
    rng = np.random.default_rng(5)
    maxima = TRUTH.rvs(12, random_state=rng)
    known = record("p", maxima, 30)
    # All volumes are alike but for one: their spread is less than that of the maxima.
    volumes = np.append(np.full(40, 9.0), 9.5)
    alike = replace(known, log_volumes=volumes, volumes_sigma=np.zeros(41))
    assert region_of([alike]).of_maxima == 1.0
    twice = replace(known, log_volumes=maxima.mean() + 2.0 * (maxima - maxima.mean()))
    assert region_of([twice]).of_maxima == pytest.approx(0.5)


def test_the_method_tells_records_years_and_what_was_left_out() -> None:
    rng = np.random.default_rng(5)
    known = replace(record("p", TRUTH.rvs(9, random_state=rng), 30), n_left_out=3)
    method = fitted([known], rng).method
    assert "; 9 records over winters 1971 to 2000 (a test): 0.3 a year; " in method
    assert method.endswith("; 3 undated or outside these years left out")


@pytest.mark.parametrize("n_below", [0, 7])
def test_shares_over_a_threshold_follow_jeffreys_rule(n_below: int) -> None:
    rng = np.random.default_rng(8)
    volumes = np.concatenate([np.linspace(8.0, 8.9, n_below), np.linspace(9.1, 11.0, 9)])
    known = record("p", volumes, 40)
    region = region_of([known], "gpd", float(np.exp(9.0)))
    draws = fit_volume_frequency(region, "p", rng, 20_000).draws
    assert isinstance(draws, ThresholdDraws)
    assert draws.weight.shape == (len(draws.share_over), n_below)
    if n_below:
        assert draws.weight.sum(axis=1) == pytest.approx(1.0)
        assert np.mean(draws.share_over) == pytest.approx(9.5 / 17.0, abs=0.01)
        assert np.var(draws.share_over) == pytest.approx(9.5 * 7.5 / (17.0**2 * 18.0), rel=0.15)
    else:
        np.testing.assert_array_equal(draws.share_over, 1.0)


def test_other_paths_narrow_what_four_maxima_tell() -> None:
    rng = np.random.default_rng(8)
    spreads = []
    for _ in range(6):
        short = record("short", TRUTH.rvs(4, random_state=rng), 30)
        others = [world(f"p{i}", 100, rng) for i in range(5)]
        for some in ([short, *others], [short]):
            levels = fitted(some, np.random.default_rng(1)).draws.log_volume(0.01)
            spreads.append(np.ptp(np.quantile(levels, [0.05, 0.95])))
    together, alone = np.reshape(spreads, (6, 2)).mean(axis=0)
    assert together < 0.8 * alone


def test_rows_by_path_in_the_order_of_periods(write: Write) -> None:
    text = "path_id,return_period_years,volume_m3,note\nb,100,5e4,x\nb,10,1e4,\na,30,2e4,\n"
    found = read_return_volumes(write("table.csv", text))
    assert found == {"b": [(10.0, 1e4), (100.0, 5e4)], "a": [(30.0, 2e4)]}


def test_every_bad_row_is_told(write: Write) -> None:
    text = "path_id,return_period_years,volume_m3\na,1,1e4\na,10,-3\nb,10,2e4\nb,30,1e4\nb,30,3e4\n"
    with pytest.raises(RejectedRows) as caught:
        read_return_volumes(write("table.csv", text))
    found = [(p.line, p.column) for p in caught.value.problems]
    assert found[:2] == [(2, "return_period_years"), (3, "volume_m3")]
    assert {line for line, _ in found[2:]} <= {5, 6}
    assert len(found) > 2


def test_files_that_cannot_be_read(write: Write, tmp_path: FilePath) -> None:
    with pytest.raises(AvahazardError, match="cannot be read"):
        read_return_volumes(tmp_path / "nothing.csv")
    with pytest.raises(AvahazardError, match="has no rows") as caught:
        read_return_volumes(write("empty.csv", "path_id,return_period_years,volume_m3\n"))
    assert "volume_m3" in caught.value.hint
    with pytest.raises(RejectedRows):
        read_return_volumes(write("blank.csv", ""))


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


@pytest.fixture
def frequencies() -> Frequencies:
    """Twelve events in thirty years of path p, and no volume."""
    none = np.empty(0)
    record = VolumeRecord("p", 1971, 2000, "a test", 12, 9, 0, none, none, none, none)
    refused = {"p": AvahazardError("There are no volumes.", "Measure some.")}
    return Frequencies(region_of([record]), refused, 5, VolumeSource(), None, fit_trend([record]))


def test_its_rate_is_that_of_a_poisson_process(frequencies: Frequencies) -> None:
    with pytest.raises(AvahazardError, match="no volumes"):
        frequencies.of("p")
    found = frequencies.rate_alone("p")
    assert found is not None
    # Jeffreys' prior: gamma of shape n + 1/2.
    assert np.mean(found.rate) == pytest.approx(12.5 / 30.0, rel=0.02)
    assert np.std(found.rate) == pytest.approx(12.5**0.5 / 30.0, rel=0.05)
    assert (found.share == 1.0).all()
    assert frequencies.rate_alone("nobody") is None


def test_it_is_trusted_for_twice_the_observed_years(frequencies: Frequencies) -> None:
    assert not frequencies.extrapolated("p", 60.0)
    assert frequencies.extrapolated("p", 60.5)


def held(thing: object) -> Iterator[object]:
    """All that an object leads to."""
    seen: set[int] = set()
    left = [thing]
    while left:
        one = left.pop()
        if id(one) not in seen and not isinstance(one, type):
            seen.add(id(one))
            yield one
            left += gc.get_referents(one)


def test_a_refusal_holds_no_records() -> None:
    known = [dated_volumes(Path("P"), (Event("e", "P", runout_x_m=1.0),))]
    refused = volume_frequencies(known, 1).refused
    assert isinstance(refused["P"], AvahazardError)
    assert not any(isinstance(thing, Event) for thing in held([known, refused]))
