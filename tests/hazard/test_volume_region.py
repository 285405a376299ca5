from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from avahazard.hazard.frequency import KnownVolumes, volume_frequencies
from avahazard.hazard.shape_grid import gev_likelihood, over_locations
from avahazard.hazard.volume_region import FEWEST_TELLING, PATHS_AT_ONCE, VolumeRecord, region_of
from avahazard.hazard.volume_source import VolumeSource
from avahazard.workers import set_workers

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
    found = region.together()
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
            sums.append(region_of(records).together().likelihood)
        finally:
            set_workers(None)
    np.testing.assert_array_equal(*sums)


def test_the_error_of_all_is_that_of_all_maxima(records: list[VolumeRecord]) -> None:
    region = region_of(records)
    sigma = np.concatenate([r.maxima_sigma for r in records])
    expected = region._of_maxima * np.sqrt(np.mean(sigma**2))
    assert [region.error(), region.error()] == pytest.approx([expected] * 2)
    (one,) = (r for r in records if r.path_id == "P3")
    alone = region._of_maxima * np.sqrt(np.mean(one.maxima_sigma**2))
    assert region.error("P3") == pytest.approx(alone)
    without = replace(one, log_maxima=np.empty(0), maxima_sigma=np.empty(0))
    assert region_of([without]).error() == 0.0


def test_workers_are_given_what_all_say_where_records_are_asked(
    records: list[VolumeRecord], tmp_path: Path
) -> None:
    known = KnownVolumes(records=records)
    assert "together" in volume_frequencies(known, 1).region.kept
    table = tmp_path / "volumes.csv"
    table.write_text("path_id,return_period_years,volume_m3\nP1,30,1000\nP1,100,2000\n")
    of_table = volume_frequencies(known, 1, VolumeSource(table=table))
    assert "together" not in of_table.region.kept
