"""Errors of release elevations, and what they do to the records of stops."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.release_errors import half_difference
from avahazard.records.collection import Event, Path, Records
from avahazard.records.errors import AvahazardError
from avahazard.synth.dataset import make_track, run_track
from tests.inference.studies import profile

Z0, SIGMA_Z, MU = 900.0, 20.0, 0.5
GROUND = profile(0)
TRACK = make_track(GROUND.x_m, GROUND.y_m)


def stop(z0: float) -> tuple[float, float]:
    """Where a block of friction MU stops that starts at that elevation."""
    status, x, _ = run_track(TRACK, TRACK.place(np.array([z0])), np.array([MU]))
    assert status[0] == 0
    return float(x[0]), float(TRACK.elevation(x)[0])


@cache
def events() -> tuple[Event, ...]:
    """Recorded by elevation and by place, left, and without a profile."""
    x, y = stop(Z0)
    return (
        Event("y", "P0", runout_elevation_m=y, runout_sigma_m=15.0, release_elevation_m=Z0),
        Event("x", "P0", runout_x_m=x, runout_sigma_m=15.0, release_elevation_m=Z0),
        Event("l", "P0", left_profile=True, release_elevation_m=Z0),
        Event("s", fall_height_m=400.0, runout_length_m=900.0, runout_sigma_m=15.0),
    )


def built(*events: Event, **of_path: float | str) -> Observations:
    path = Path("P0", covariates=of_path)
    return build_observations(Records((path,), (GROUND,), events))


def with_error(event: Event, sigma: float | str = SIGMA_Z) -> Event:
    return replace(event, covariates={"release_sigma_m": sigma})


def test_it_is_what_another_release_does_to_the_stop() -> None:
    found = built(*map(with_error, events()))
    (low_x, low_y), (high_x, high_y) = stop(Z0 - SIGMA_Z), stop(Z0 + SIGMA_Z)
    exact = np.array([abs(high_y - low_y), abs(high_x - low_x)]) / 2.0
    assert exact.min() > 5.0
    np.testing.assert_allclose(found.release_sigma[:2], exact, rtol=0.05)
    # H/L is the friction: a fall that is off by σ is a length that is off by σ L/H.
    assert found.release_sigma[3] == pytest.approx(SIGMA_Z * 900.0 / 400.0)
    known = [0, 1, 3]
    np.testing.assert_allclose(found.sigma[known], np.hypot(15.0, found.release_sigma[known]))


def friction_to_the_end(z0: float) -> float:
    """The friction under which a block that starts at that elevation runs beyond the profile."""
    start = TRACK.place(np.array([z0]))
    low, high = 0.2, 0.6
    for _ in range(30):
        middle = 0.5 * (low + high)
        status, _, _ = run_track(TRACK, start, np.array([middle]))
        low, high = (low, middle) if status[0] == 0 else (middle, high)
    return low


def test_what_left_is_off_in_the_friction_that_lets_it() -> None:
    found = built(*map(with_error, events()))
    low, high = (np.log(friction_to_the_end(Z0 + s)) for s in (-SIGMA_Z, SIGMA_Z))
    assert found.leaving_sigma[2] == pytest.approx(0.5 * (high - low), rel=0.05)
    # In elevation, where the ground is nearly flat.
    assert 0.1 < found.release_sigma[2] < 2.0
    assert found.sigma[2] == pytest.approx(
        np.hypot(events()[2].runout_sigma_m, found.release_sigma[2])
    )
    assert not built(*events()).leaving_sigma.any()


def test_a_block_that_leaves_or_does_not_start_tells_nothing() -> None:
    assert half_difference(5.0, 2.0, 1.0) == 2.0
    assert half_difference(np.nan, 2.0, 1.5) == 0.5
    assert half_difference(5.0, 2.0, np.nan) == 3.0
    assert half_difference(5.0, np.nan, np.nan) == 0.0


def test_the_paths_error_is_that_of_events_that_state_none() -> None:
    in_y, in_x, *_ = events()
    own = with_error(in_x, 2.0 * SIGMA_Z)
    found = built(in_y, own, release_sigma_m=SIGMA_Z).release_sigma
    both = built(with_error(in_y), own).release_sigma
    np.testing.assert_array_equal(found, both)


def test_where_none_is_stated_nothing_changes_and_it_drives_nothing() -> None:
    bare = built(*events())
    assert np.array_equal(bare.sigma[[0, 1, 3]], [15.0, 15.0, 15.0])
    assert not bare.release_sigma.any()
    stated = built(*map(with_error, events()))
    assert "release_sigma_m" not in stated.columns.numbers


@pytest.mark.parametrize("wrong", ["far", -1.0, float("nan"), float("inf")])
def test_what_is_no_error_is_refused(wrong: float | str) -> None:
    with pytest.raises(AvahazardError, match="release_sigma_m of event x"):
        built(with_error(events()[1], wrong))
