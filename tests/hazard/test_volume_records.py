"""Records of volumes, of one path and of all."""

from dataclasses import replace
from datetime import date, timedelta
from pathlib import Path as FilePath

import numpy as np
import pytest
from scipy import stats

from avahazard.hazard.extremes import gev_likelihood, over_locations
from avahazard.hazard.frequency import volume_frequencies
from avahazard.hazard.volume_records import (
    FEWEST_TELLING,
    PATHS_AT_ONCE,
    DatedVolumes,
    VolumeRecord,
    data_window,
    dated_volumes,
    region_of,
    unobserved_years,
    volume_record,
    without_record_error,
)
from avahazard.hazard.volume_source import VolumeSource
from avahazard.records.collection import WINTER_STARTS, Event, Path
from avahazard.records.errors import AvahazardError
from avahazard.workers import set_workers


def event(number: int, date: str | None, volume: float | None) -> Event:
    return Event(f"e{number}", "p", date=date, runout_x_m=1.0, volume_m3=volume)


EVENTS = [
    event(1, "1950-02-13", 1000.0),
    event(2, "1950-12-30", 3000.0),
    event(3, "1961", 500.0),
    event(4, "1962-01-01", None),
    event(5, None, 9e5),
]


def record_of(path: Path, events: list[Event], starts: int = WINTER_STARTS) -> VolumeRecord:
    """The record of a path that is all of the data."""
    own = dated_volumes(path, events)
    return volume_record(own, data_window([own], starts), starts)


def test_largest_volume_of_each_winter() -> None:
    record = record_of(Path("p", observed_from=1941, observed_to=1980), EVENTS)
    # December 1950 is of the next winter; 1961 alone is the winter that ends in it.
    np.testing.assert_allclose(np.exp(record.log_maxima), [1000, 3000, 500])
    assert (record.n_years, record.n_events, record.n_event_years) == (40, 4, 4)
    assert record.events_per_year == pytest.approx(0.1)
    assert record.n_left_out == 1
    assert record.window == "observed_from to observed_to"
    np.testing.assert_allclose(np.exp(record.log_volumes), [1000, 3000, 500])


def test_gaps_are_taken_from_the_years_and_their_records_left_out() -> None:
    path = Path(
        "p",
        observed_from=1941,
        observed_to=1980,
        covariates={"not_observed": "1935-1944; 1950;1979 - 1990"},
    )
    record = record_of(path, EVENTS)
    assert (len(record.gaps), record.n_years) == (4 + 1 + 2, 33)
    assert (record.n_events, record.n_left_out) == (3, 2)
    assert record.events_per_year == pytest.approx(3 / 33)


@pytest.mark.parametrize(
    ("text", "years"),
    [("1943", {1943}), (1943.0, {1943}), ("1914-1916;1943", {1914, 1915, 1916, 1943})],
)
def test_years_that_nobody_observed(text: str | float, years: set[int]) -> None:
    assert unobserved_years("p", text) == years


@pytest.mark.parametrize("text", ["the war", "1918-1914", "14-18"])
def test_gaps_that_do_not_read(text: str) -> None:
    with pytest.raises(AvahazardError, match="not_observed of path p") as error:
        unobserved_years("p", text)
    assert "1914-1918;1943" in error.value.hint


def test_the_error_of_the_records_is_taken_from_their_spread() -> None:
    rng = np.random.default_rng(1)
    records = []
    for k in range(40):
        true = rng.normal(10.0 + k, 0.8, 30)
        seen = true + rng.normal(0.0, 0.6, 30)
        sigma = np.full(30, 0.6)
        records.append(VolumeRecord(f"p{k}", 1900, 1999, "", 30, 30, 0, seen, sigma, seen, sigma))
    freed = without_record_error(records)
    spread = np.sqrt(np.mean([np.var(r.log_volumes, ddof=1) for r in freed]))
    assert spread == pytest.approx(0.8, abs=0.03)
    for before, after in zip(records, freed, strict=True):
        assert after.log_volumes.mean() == pytest.approx(before.log_volumes.mean())
    exact = [replace(r, maxima_sigma=np.zeros(30), volumes_sigma=np.zeros(30)) for r in records]
    np.testing.assert_allclose(without_record_error(exact)[0].log_maxima, exact[0].log_maxima)


def test_two_volumes_of_a_path_tell_of_their_spread_and_one_does_not() -> None:
    def of(name: str, *log_volumes: float) -> VolumeRecord:
        values, sigma = np.array(log_volumes), np.full(len(log_volumes), 0.5)
        n = len(values)
        return VolumeRecord(name, 1900, 1999, "", n, n, 0, values, sigma, values, sigma)

    pair, alone = of("pair", 9.0, 11.0), of("alone", 10.0)
    # Their variance is 2, of which 0.25 is error.
    freed, same = without_record_error([pair, alone])
    shrunk = np.sqrt(1.75 / 2.0)
    np.testing.assert_allclose(freed.log_volumes, [10.0 - shrunk, 10.0 + shrunk])
    np.testing.assert_allclose(same.log_volumes, [10.0])
    assert without_record_error([alone])[0] is alone


def test_a_year_begins_in_the_month_that_is_asked_for() -> None:
    path = Path("p", observed_from=1941, observed_to=1980)
    calendar = record_of(path, EVENTS, starts=1)
    np.testing.assert_allclose(np.exp(calendar.log_maxima), [3000, 500])
    assert (calendar.n_event_years, calendar.seasons) == (3, "years")
    from_july = record_of(path, [event(1, "1950-06-30", 1.0), event(2, "1950-07-01", 2.0)], 7)
    assert (from_july.n_event_years, from_july.first_year) == (2, 1941)


def test_thirty_days_later_within_the_winter_the_maxima_are_the_same() -> None:
    path = Path("p", observed_from=1941, observed_to=1980)
    rng = np.random.default_rng(4)
    days = [
        date(int(y), 11, 15) + timedelta(int(d))
        for y, d in rng.integers(0, 90, (30, 2)) + np.array([1942, 0])
        if y < 1979
    ]
    found = [
        record_of(
            path, [event(k, str(day + timedelta(more)), 1.0 + k) for k, day in enumerate(days)]
        )
        for more in (0, 31)
    ]
    np.testing.assert_array_equal(found[0].log_maxima, found[1].log_maxima)
    assert found[0].n_event_years == found[1].n_event_years


def test_the_winters_of_the_data_set_without_observed_years() -> None:
    sparse = dated_volumes(Path("p"), [event(1, "2017-01-20", 1e3), event(2, "2022-02-01", 2e3)])
    other = dated_volumes(Path("q"), [event(3, "2005-12-30", None), event(4, "2010", None)])
    none = dated_volumes(Path("r"), [])
    window = data_window([sparse, other, none], WINTER_STARTS)
    assert window == (2006, 2022)
    record = volume_record(sparse, window)
    assert (record.first_year, record.last_year, record.n_years) == (2006, 2022, 17)
    assert record.events_per_year == pytest.approx(2 / 17)
    assert record.window == "the first to the last record of any path"
    with pytest.raises(AvahazardError, match="No event of path r is dated"):
        volume_record(none, window)
    frequencies = volume_frequencies([sparse, other, none], 1)
    (note,) = frequencies.notes("p")
    assert note.startswith("the rate of avalanches counts the path's records over the winters ")
    assert "from 2006 to 2022" in note
    assert frequencies.notes("r") == []
    # The rate is uncertain: a gamma distribution of shape n + 1/2.
    rate = frequencies.rate_alone("p")
    assert rate is not None
    assert np.quantile(rate.rate, [0.05, 0.95]) == pytest.approx(
        stats.gamma(2.5, scale=1 / 17).ppf([0.05, 0.95]), rel=0.15
    )


@pytest.mark.parametrize(
    ("path", "years", "window"),
    [
        (
            Path("p", observed_from=1900),
            (1900, 1962),
            "observed_from to the last record of any path",
        ),
        (Path("p", observed_to=2000), (1950, 2000), "the first record of any path to observed_to"),
    ],
)
def test_one_end_given(path: Path, years: tuple[int, int], window: str) -> None:
    record = record_of(path, EVENTS)
    assert (record.first_year, record.last_year) == years
    assert record.window == window
    note = volume_frequencies([dated_volumes(path, EVENTS)], 1).notes("p")[0]
    lacking = "observed_from" if path.observed_from is None else "observed_to"
    assert f"as {lacking} is missing. Give it" in note


def test_records_outside_the_observed_years_are_left_out() -> None:
    record = record_of(Path("p", observed_from=1960, observed_to=1970), EVENTS)
    assert (record.n_events, record.n_left_out) == (2, 3)
    np.testing.assert_allclose(np.exp(record.log_maxima), [500])


@pytest.mark.parametrize(
    ("path", "events", "message"),
    [
        (Path("p"), EVENTS[4:], "No event of path p is dated"),
        (Path("p"), EVENTS[:1], "are of 1950"),
        (Path("p", observed_from=1980, observed_to=1990), EVENTS, "1980 to 1990"),
        (Path("p", observed_from=1980, observed_to=1990), [], "1980 to 1990"),
    ],
)
def test_no_rate(path: Path, events: list[Event], message: str) -> None:
    with pytest.raises(AvahazardError, match=message) as error:
        record_of(path, events)
    assert "--volume" in error.value.hint


def test_a_volume_of_nothing_is_no_size() -> None:
    path = Path("p", observed_from=1941, observed_to=1980)
    record = record_of(path, [*EVENTS, event(6, "1970", 0.0)])
    np.testing.assert_allclose(np.exp(record.log_volumes), [1000, 3000, 500])
    assert record.n_events == 5


N_PATHS = 2 * PATHS_AT_ONCE + 7


@pytest.fixture(scope="module")
def records() -> list[VolumeRecord]:
    """More paths than one piece of the sum; some have too few maxima to tell."""
    rng = np.random.default_rng(4)
    found = []
    for k in range(N_PATHS):
        n = int(rng.integers(1, 9))
        values = stats.genextreme(0.1, 9.0, 1.2).rvs(n, random_state=rng)
        sigma = rng.uniform(0.1, 0.5, n)
        told = values, sigma, values, sigma
        found.append(VolumeRecord(f"P{k}", 1961, 2000, "a test", n, n, 0, *told))
    return found


def test_all_paths_together_are_the_sum_of_each(records: list[VolumeRecord]) -> None:
    region = region_of(records)
    telling = [r for r in records if len(r.log_maxima) >= FEWEST_TELLING]
    expected = np.sum(
        [
            over_locations(gev_likelihood(r.log_maxima, error=region.error(r.path_id)))
            for r in telling
        ],
        axis=0,
    )
    found = region.together
    assert (found.n_paths, found.n_values) == (
        len(telling),
        sum(len(r.log_maxima) for r in telling),
    )
    near = expected > expected.max() - 100.0
    np.testing.assert_allclose(found.likelihood[near], expected[near], rtol=1e-12)
    assert np.all(found.likelihood[~near] < expected.max() - 99.0)


def test_the_sum_is_the_same_by_any_number_of_workers(records: list[VolumeRecord]) -> None:
    sums = []
    for workers in (1, 3):
        set_workers(workers)
        try:
            sums.append(region_of(records).together.likelihood)
        finally:
            set_workers(None)
    np.testing.assert_array_equal(*sums)


def test_the_error_of_all_is_that_of_all_maxima(records: list[VolumeRecord]) -> None:
    region = region_of(records)
    sigma = np.concatenate([r.maxima_sigma for r in records])
    expected = region.of_maxima * np.sqrt(np.mean(sigma**2))
    assert region.error(*region.recorded) == pytest.approx(expected)
    (one,) = (r for r in records if r.path_id == "P3")
    alone = region.of_maxima * np.sqrt(np.mean(one.maxima_sigma**2))
    assert region.error("P3") == pytest.approx(alone)
    without = replace(one, log_maxima=np.empty(0), maxima_sigma=np.empty(0))
    assert region_of([without]).error(without.path_id) == 0.0


def test_workers_are_given_what_all_say_where_records_are_asked(
    records: list[VolumeRecord], tmp_path: FilePath
) -> None:
    known = [
        DatedVolumes(
            *(r.path_id, r.first_year, r.last_year, None),
            *(1961 + np.arange(len(r.log_volumes)), np.ones(len(r.log_volumes), np.int64)),
            *(r.log_volumes, r.volumes_sigma, 0),
        )
        for r in records
    ]
    assert "together" in vars(volume_frequencies(known, 1).region)
    table = tmp_path / "volumes.csv"
    table.write_text("path_id,return_period_years,volume_m3\nP1,30,1000\nP1,100,2000\n")
    of_table = volume_frequencies(known, 1, VolumeSource(table=table))
    assert "together" not in vars(of_table.region)
