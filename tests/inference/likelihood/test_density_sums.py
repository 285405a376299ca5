"""exp, log and sums over nodes, against libraries."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.terms import (
    LOWEST,
    density_sums,
    exp_memory,
    exponentials,
    logarithms,
    sum_memory,
)
from avahazard.kernels import kernel


@kernel
def exps(x, n):  # type: ignore[no-untyped-def]
    exponentials(x, n, exp_memory(len(x)))


@kernel
def logs(x, n):  # type: ignore[no-untyped-def]
    logarithms(x, x.view(np.int64), n, exp_memory(len(x)))


def test_exponentials_are_exact_to_the_last_digit_but_one() -> None:
    rng = np.random.default_rng(0)
    x = np.concatenate([[0.0, -0.5 * np.log(2.0), -1e-300, -708.0], rng.uniform(-700, 700, 2000)])
    found = x.copy()
    exps(found, len(x))
    np.testing.assert_allclose(found, np.exp(x), rtol=4e-16)
    assert found[0] == 1.0


def test_what_is_far_below_is_next_to_nothing_and_nan_stays() -> None:
    x = np.array([-1e6, -np.inf, np.nan, LOWEST, -1.0])
    exps(x, 4)
    np.testing.assert_array_less(0.0, x[:2])
    np.testing.assert_array_less(x[:2], 1e-300)
    assert np.isnan(x[2])
    assert x[4] == -1.0  # only the first ones are asked for


def test_logarithms_are_exact_to_the_last_digits() -> None:
    rng = np.random.default_rng(1)
    edges = np.array([1.0, 2.0, 0.5, np.sqrt(0.5), np.sqrt(2.0), 1.0 + 1e-15, 1e-300, 1e300])
    x = np.concatenate([edges, np.exp(rng.uniform(-690, 690, 2000)), rng.uniform(0.5, 2.0, 2000)])
    found = x.copy()
    logs(found, len(x))
    np.testing.assert_allclose(found, np.log(x), rtol=5e-16)
    assert found[0] == 0.0


PLACE = np.array([-1.1, -0.8, -0.7, -0.4, 0.3])
WEIGHT = np.array([0.1, 0.3, 0.2, 0.3, 0.1])
LOCATION, SCATTER = np.array([-0.7, -0.5, -0.9]), np.array([0.2, 0.5, 0.1])
LIFT, STEP = -0.4, 1e-4


@kernel
def compiled_sums(place, weight, location, scatter, lift, student, slopes, out):  # type: ignore[no-untyped-def]
    memory = sum_memory(place.size * location.size)
    density_sums(place, weight, location, scatter, lift, student, slopes, memory, out)


def as_written(student: bool, shift: float = 0.0, stretch: float = 1.0) -> np.ndarray:
    law = stats.t(4) if student else stats.norm()
    scatter = (SCATTER * stretch)[:, None]
    density = law.pdf((PLACE - LOCATION[:, None] - shift) / scatter) / scatter
    return density @ WEIGHT * (1.0 if student else np.exp(LIFT))


def sums(student: bool, slopes: bool) -> np.ndarray:
    out = np.full((3, 4), np.nan)
    compiled_sums(PLACE, WEIGHT, LOCATION, SCATTER, LIFT, student, slopes, out)
    return out


@pytest.mark.parametrize("student", [False, True])
def test_values_and_derivatives(student: bool) -> None:
    found = sums(student, slopes=True)
    here = as_written(student)
    np.testing.assert_allclose(found[:, 0], here, rtol=1e-12)
    up, down = as_written(student, STEP), as_written(student, -STEP)
    np.testing.assert_allclose(found[:, 1], (up - down) / (2.0 * STEP), rtol=1e-5)
    np.testing.assert_allclose(found[:, 3], (up - 2.0 * here + down) / STEP**2, rtol=1e-4)
    wide, narrow = (as_written(student, stretch=np.exp(h)) for h in (STEP, -STEP))
    np.testing.assert_allclose(found[:, 2], (wide - narrow) / (2.0 * STEP), rtol=1e-5)


@pytest.mark.parametrize("student", [False, True])
def test_without_slopes_the_values_are_the_same_and_derivatives_are_nought(student: bool) -> None:
    found = sums(student, slopes=False)
    np.testing.assert_allclose(found[:, 0], sums(student, slopes=True)[:, 0], rtol=1e-14)
    np.testing.assert_array_equal(found[:, 1:], 0.0)
