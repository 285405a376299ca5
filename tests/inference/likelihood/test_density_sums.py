"""Sums over nodes, against scipy's densities and their differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.density_sums import normal_sums, student_sums, sum_memory

PLACE = np.array([-1.1, -0.8, -0.7, -0.4, 0.3])
WEIGHT = np.array([0.1, 0.3, 0.2, 0.3, 0.1])
LOCATION, SCATTER = np.array([-0.7, -0.5, -0.9]), np.array([0.2, 0.5, 0.1])
LIFT, STEP = -0.4, 1e-4


def as_written(student: bool, shift: float = 0.0, stretch: float = 1.0) -> np.ndarray:
    law = stats.t(4) if student else stats.norm()
    scatter = (SCATTER * stretch)[:, None]
    density = law.pdf((PLACE - LOCATION[:, None] - shift) / scatter) / scatter
    return density @ WEIGHT * (1.0 if student else np.exp(LIFT))


def sums(student: bool, slopes: bool) -> np.ndarray:
    out, memory = np.full((3, 4), np.nan), sum_memory(len(PLACE) * 3)
    if student:
        student_sums(PLACE, WEIGHT, LOCATION, SCATTER, slopes, memory, out)
    else:
        normal_sums(PLACE, WEIGHT, LOCATION, SCATTER, LIFT, slopes, memory, out)
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
