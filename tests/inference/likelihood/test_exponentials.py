"""exp and log in vectors against the library's."""

from __future__ import annotations

import numpy as np

from avahazard.inference.likelihood.exponentials import (
    LOWEST,
    exp_memory,
    exponentials,
    logarithms,
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
