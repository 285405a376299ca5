"""The scatter of friction against SciPy's distributions, and derivatives against differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.model import friction_model as scatter

Z = np.linspace(-7.0, 7.0, 29)
STUDENT = stats.t(4)


def test_the_densities_and_chances_of_the_kernels_are_scipys() -> None:
    for z in Z:
        assert scatter.normal_density(z) == pytest.approx(stats.norm.pdf(z), rel=1e-13)
        assert scatter.normal_below(z) == pytest.approx(stats.norm.cdf(z), rel=1e-13)
        assert scatter.student_density(z)[0] == pytest.approx(STUDENT.pdf(z), rel=1e-13)
        assert scatter.student_below(z) == pytest.approx(STUDENT.cdf(z), rel=1e-12, abs=1e-15)
    for z in (-50.0, -3e3, -1e7):
        assert scatter.student_below(z) == pytest.approx(STUDENT.cdf(z), rel=1e-9)


def test_the_derivatives_of_students_density_are_its_differences() -> None:
    h = 1e-3
    for z in Z:
        density, pull, bend = scatter.student_density(z)
        up, down = STUDENT.pdf(z + h), STUDENT.pdf(z - h)
        assert -pull * density == pytest.approx((up - down) / (2.0 * h), abs=1e-6)
        assert bend * density == pytest.approx((up - 2.0 * density + down) / h**2, abs=1e-6)


def test_the_information_in_log_scale_is_the_mean_square_of_the_score() -> None:
    z = np.linspace(-400.0, 400.0, 800_001)
    score = z * scatter.STUDENT_PULL * z / (1.0 + 0.25 * z**2) - 1.0
    information = np.trapezoid(score**2 * STUDENT.pdf(z), z)
    assert information == pytest.approx(scatter.STUDENT_INFORMATION, rel=1e-5)


@pytest.mark.parametrize(("student", "law"), [(False, stats.norm), (True, STUDENT)])
def test_arrays_say_what_scipy_says(student: bool, law: stats.rv_frozen) -> None:
    np.testing.assert_allclose(scatter.below(Z, student), law.cdf(Z), rtol=1e-12)
    np.testing.assert_allclose(scatter.log_density(Z, student), law.logpdf(Z), rtol=1e-12)
    drawn = scatter.draws(np.random.default_rng(0), 20_000, student)
    assert stats.kstest(drawn, law.cdf).pvalue > 0.01


def test_a_normal_draw_that_is_widened_is_students() -> None:
    rng = np.random.default_rng(1)
    drawn = rng.standard_normal(20_000) * scatter.widening(rng, 20_000)
    assert stats.kstest(drawn, STUDENT.cdf).pvalue > 0.01


def test_a_shift_is_one_of_log_friction_in_either_form() -> None:
    mu, shift, deviation = np.array([0.2, 0.4]), 0.3, np.array([-0.05, 0.1])
    in_log = scatter.friction(scatter.shifted(np.log(mu), shift, True), deviation, True)
    np.testing.assert_allclose(in_log, mu * np.exp(shift + deviation))
    plain = scatter.friction(scatter.shifted(mu, shift, False), deviation, False)
    np.testing.assert_allclose(plain, mu * np.exp(shift) + deviation)
