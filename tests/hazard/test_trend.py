"""Trends of rate and volumes over the years, and what they make of a year."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from avahazard.hazard.extremes import Gev, GevDraws
from avahazard.hazard.frequency import return_volume, volume_frequencies
from avahazard.hazard.trend import Slope, Trend, as_of, fit_trend, rate_factor
from avahazard.hazard.volume_records import DatedVolumes, VolumeRecord
from avahazard.hazard.volume_source import VolumeSource
from avahazard.records.errors import AvahazardError

GAPS = frozenset({1940, 1941})


def record(rng: np.random.Generator, k: int, rate: float = 0.0, size: float = 0.0) -> VolumeRecord:
    """A path whose rate and volumes change by these slopes (log a year); not observed in `GAPS`."""
    first = 1920 + 10 * (k % 3)
    years = np.setdiff1d(np.arange(first, 2021), list(GAPS))
    of_event = np.repeat(years, rng.poisson(0.25 * np.exp(rate * (years - 1970.0))))
    volumes = rng.normal(9.0, 1.0, len(of_event)) + size * (of_event - 1970.0)
    n, own = len(of_event), GAPS & set(range(first, 2021))
    return VolumeRecord(
        *(f"p{k}", first, 2020, "a test", n, len(np.unique(of_event)), 0),
        *(volumes, 0.0 * volumes, volumes, 0.0 * volumes),
        gaps=frozenset(own),
        event_years=of_event,
        volume_years=of_event,
    )


def dated(found: VolumeRecord) -> DatedVolumes:
    """The same as the records give it."""
    n = len(found.event_years)
    return DatedVolumes(
        *(found.path_id, found.first_year, found.last_year, "1940-1941"),
        *(found.event_years, np.ones(n, np.int64), found.log_volumes, np.full(n, 0.3), 0),
    )


@pytest.mark.parametrize(("rate", "size"), [(0.0, 0.0), (0.015, 0.0), (0.0, -0.02)])
def test_a_trend_that_is_there_is_found_and_no_other(rate: float, size: float) -> None:
    found = [
        fit_trend([record(rng, k, rate, size) for k in range(6)])
        for rng in map(np.random.default_rng, range(60))
    ]
    for slope, slopes in ((rate, [t.rate for t in found]), (size, [t.size for t in found])):
        known = [s for s in slopes if s is not None]
        assert len(known) == len(found)
        z = [(s.mean - 10.0 * slope) / s.se for s in known]
        assert abs(np.mean(z)) < 0.5
        assert 0.75 < np.std(z) < 1.25
        seen = np.mean([s.p_value < 0.01 for s in known])
        assert seen > 0.8 if slope else seen < 0.1
    notes = [note.key for trend in found for note in trend.notes(None)]
    assert (notes.count("rate_trend") > 45) == (rate > 0.0)
    assert (notes.count("size_trend") > 45) == (size < 0.0)


def test_winters_of_many_avalanches_are_no_trend() -> None:
    """Records of one winter on all paths are one event of the weather."""
    rng = np.random.default_rng(3)
    p_values = []
    for _ in range(60):
        winters = rng.choice(np.arange(1950, 2020), 12, replace=False)
        records = [
            replace(record(rng, k), event_years=winters, n_events=12, gaps=frozenset())
            for k in range(3, 9)
        ]
        trend = fit_trend(records)
        assert trend.rate is not None
        p_values.append(trend.rate.p_value)
    assert np.mean(np.array(p_values) < 0.01) < 0.08


def test_too_few_records_have_no_trend() -> None:
    few = [replace(record(np.random.default_rng(1), 0), event_years=np.array([1990] * 30))]
    assert fit_trend([]).rate is fit_trend(few).rate is None


def test_a_year_has_its_rate_and_its_volumes() -> None:
    known = record(np.random.default_rng(2), 1)
    sure = Trend(Slope(0.2, 0.0, 0.0), Slope(-0.1, 0.0, 0.0), 1920, 2020)
    rng = np.random.default_rng(0)
    factor = rate_factor(sure, known, 2020, 3, rng)
    years = known.observed_years()
    assert GAPS.isdisjoint(years.tolist())
    np.testing.assert_allclose(factor, np.exp(0.02 * 2020) / np.exp(0.02 * years).mean())
    gev = Gev(np.full(3, 0.1), np.full(3, 9.0), np.full(3, 1.0))
    draws = GevDraws(np.full(3, 0.2), gev)
    found = as_of(draws, sure, known, 2020, rng)
    shift = -0.01 * (2020 - known.volume_years.mean())
    np.testing.assert_allclose(found.rate, draws.rate * factor)
    at = np.linspace(8.0, 13.0, 30)
    expected = draws.rate_over(at - shift) * factor[:, None]
    np.testing.assert_allclose(found.rate_over(at), expected, atol=2e-4)
    # A year's largest exceeds it with the chance that was asked for.
    volume = found.log_volume(0.01)
    np.testing.assert_allclose(found.rate_over(volume)[:, 0], -np.log1p(-0.01), rtol=0.01)
    low, high = draws.ends()
    assert found.ends() == pytest.approx((low + shift, high + shift))


def test_the_rate_of_a_year_is_as_uncertain_as_the_trend() -> None:
    known = record(np.random.default_rng(2), 1)
    trend = Trend(Slope(0.1, 0.05, 0.04), None, 1920, 2020)
    factor = rate_factor(trend, known, 2020, 4000, np.random.default_rng(0))
    far = 2020 - known.observed_years().mean()
    assert np.std(np.log(factor)) == pytest.approx(0.005 * far, rel=0.15)
    draws = GevDraws(np.full(4000, 0.2), Gev(*(np.full(4000, v) for v in (0.1, 9.0, 1.0))))
    assert not as_of(draws, trend, known, 2020, np.random.default_rng(0)).shift.any()


def test_frequencies_of_a_year_say_so() -> None:
    rng = np.random.default_rng(8)
    known = [dated(record(rng, k, 0.02)) for k in range(6)]
    mean = volume_frequencies(known, 1)
    assert [note.key for note in mean.notes("p1")] == ["rate_trend"]
    found = {
        year: volume_frequencies(known, 1, VolumeSource(as_of=year)) for year in (1930, 2020, 2060)
    }
    rates = [np.median(f.of("p1").draws.rate) for f in (found[1930], mean, found[2020])]
    assert rates == sorted(rates)
    assert rates[2] > 1.5 * rates[1]
    levels = [return_volume(f.of("p1"), 100.0).volume_m3 for f in (found[1930], found[2020])]
    assert levels[0] < levels[1]
    alone = found[2020].rate_alone("p1")
    assert alone is not None
    assert np.median(alone.rate) == pytest.approx(rates[2], rel=0.25)
    assert found[2020].of("p1").method.endswith("; as of 2020")
    keys = ["as_of_rate", "as_of_size"]
    assert [note.key for note in found[2020].notes("p1")] == keys
    assert [note.key for note in found[2060].notes("p1")] == [*keys, "as_of_beyond"]
    assert "the rate is that of 2020, by --as-of" in found[2020].notes("p1")[0]


def test_a_year_needs_records_of_a_trend() -> None:
    rng = np.random.default_rng(8)
    few = replace(dated(record(rng, 0)), year=np.arange(1990, 1995), n_undated=0)
    few = replace(few, month=few.year * 0 + 1, log_volume=few.year * 1.0, sigma=few.year * 0.0)
    with pytest.raises(AvahazardError, match="too few for a trend") as error:
        volume_frequencies([few], 1, VolumeSource(as_of=2000))
    assert "--as-of" in error.value.hint
    with pytest.raises(AvahazardError, match="--as-of is for volumes from records"):
        VolumeSource(as_of=2000, table="volumes.csv")  # type: ignore[arg-type]


def test_t_values_are_those_of_students_t() -> None:
    trend = fit_trend([record(np.random.default_rng(4), k) for k in range(4)])
    assert trend.rate is not None
    n_years = 101
    p = 2 * stats.t.sf(abs(trend.rate.mean) / trend.rate.se, n_years - len(GAPS) - 2)
    assert trend.rate.p_value == pytest.approx(p)
