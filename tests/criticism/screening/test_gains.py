from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.criticism.screening.gains import (
    EffectColumns,
    limit_by_chance,
    most_surprising_pair,
)
from avahazard.criticism.screening.laplace_fit import Design, Edges, LaplaceFit
from avahazard.criticism.screening.record_moments import RecordMoments

N = 60
TAU = (0.2, 0.1)
PATHS, WINTERS = np.arange(N) % 4, (np.arange(N) * 7) % 9


def design(x: np.ndarray) -> Design:
    index = np.stack([PATHS, np.where(WINTERS < 8, 4 + WINTERS, -1)])
    of = np.repeat([0, 1], [4, 8])
    return Design(
        x=x,
        constant=np.zeros(N),
        prior_mean=np.array([-0.7, 0.0]),
        prior_precision=np.array([4.0, 1.0]),
        of=of,
        places=index,
        alone=np.stack([np.zeros(N, bool), WINTERS == 8]),
        rest=np.where(of == 0, np.arange(12), -1),
        spread_scale=np.full(2, 0.2),
        extra=np.full(N, 0.001),
        multiplier=np.ones(N),
        log_wrong=np.full(N, -np.inf),
    )


def moments(mean: np.ndarray) -> RecordMoments:
    return RecordMoments(mean, np.full(N, 0.01), np.zeros(N))


def a_world(seed: int, slope: float):  # type: ignore[no-untyped-def]
    """Law, two columns that go together and a third, and log friction asked for."""
    rng = np.random.default_rng(seed)
    x = np.column_stack([np.ones(N), rng.standard_normal(N)])
    first, third = rng.standard_normal((2, N))
    second = 0.95 * first + np.sqrt(1.0 - 0.95**2) * rng.standard_normal(N)
    columns = EffectColumns(
        np.column_stack([third, first, second]), np.full(3, 25.0), np.array([0, 1, 2])
    )
    mean = -0.7 + slope * (first - second) + 0.18 * rng.standard_normal(N)
    fit = LaplaceFit(0.0, np.array([-0.65, 0.05]), float(np.log(0.15)), np.array(TAU))
    return design(x), columns, mean, fit


def gain_by_hand(d: Design, columns: EffectColumns, mean: np.ndarray, keep: list[int]) -> float:
    """Twice-penalised least squares of everything at once, offsets as columns."""
    own = np.where(WINTERS == 8, TAU[1] ** 2, 0.0)
    weight = 1.0 / (0.15**2 + own + 0.001 + 0.01)
    offsets = np.zeros((N, 12))
    for row in d.places:
        inside = row >= 0
        offsets[np.flatnonzero(inside), row[inside]] = 1.0

    def largest(extra: np.ndarray) -> float:
        z = np.column_stack([d.x, offsets, extra])
        k = extra.shape[1]
        precision = np.concatenate([d.prior_precision, np.repeat(np.array(TAU) ** -2.0, [4, 8])])
        precision = np.append(precision, np.full(k, 25.0))
        middle = np.concatenate([d.prior_mean, np.zeros(12 + k)])
        a = (z * weight[:, None]).T @ z + np.diag(precision)
        u = np.linalg.solve(a, z.T @ (weight * mean) + precision * middle)
        left = mean - z @ u
        return -0.5 * float(left @ (weight * left) + (u - middle) @ (precision * (u - middle)))

    return largest(columns.x[:, keep]) - largest(columns.x[:, :0])


def test_the_gain_of_a_pair_is_that_of_least_squares_by_hand() -> None:
    d, columns, mean, fit = a_world(1, 0.4)
    found = most_surprising_pair(moments(mean), np.zeros(N, bool), d, fit, columns, False)
    assert found is not None
    assert (found.first, found.second) == (1, 2)
    one, other = (gain_by_hand(d, columns, mean, [k]) for k in (1, 2))
    gain = gain_by_hand(d, columns, mean, [1, 2]) - max(one, other)
    assert max(one, other) < 3.0
    assert found.surprise == pytest.approx(-stats.chi2.logsf(2.0 * gain, 2), rel=1e-5)


def test_one_effect_that_shows_alone_is_no_pair_that_hides() -> None:
    rng = np.random.default_rng(3)
    surprise = []
    for seed in range(40):
        d, columns, mean, fit = a_world(seed, 0.0)
        mean = mean + (0.3 if seed % 2 else 0.0) * columns.x[:, 1]
        found = most_surprising_pair(moments(mean), rng.random(N) < 0.0, d, fit, columns, False)
        assert found is not None
        surprise.append(found.surprise)
    assert np.quantile(surprise, 0.9) < 5.0


def test_what_left_its_profile_tells_nothing_and_one_effect_is_no_pair() -> None:
    d, columns, mean, fit = a_world(1, 0.4)
    left = np.arange(N) < 20
    variance = np.where(left, 0.0, 0.01)
    wild = np.where(left, 99.0, mean)
    found = [
        most_surprising_pair(RecordMoments(m, variance, np.zeros(N)), left, d, fit, columns, False)
        for m in (mean, wild)
    ]
    assert found[0] == found[1]
    alone = EffectColumns(columns.x[:, :1], columns.precision[:1], columns.of[:1])
    assert most_surprising_pair(moments(mean), left, d, fit, alone, False) is None


@pytest.mark.parametrize("student", [False, True])
def test_each_record_is_likelier_by_the_chance_to_be_seen(student: bool) -> None:
    rng = np.random.default_rng(1)
    n = 30
    path = rng.integers(-1, 3, n)
    lone = np.zeros((2, n), dtype=np.bool_)
    lone[1, :4] = True
    design = Design(
        x=rng.normal(size=(n, 2)),
        constant=rng.normal(-0.8, 0.1, n),
        prior_mean=np.zeros(2),
        prior_precision=np.ones(2),
        of=np.zeros(3, dtype=np.int64),
        places=np.vstack([path, np.full(n, -1)]),
        alone=lone,
        rest=np.empty(0, dtype=np.int64),
        spread_scale=np.ones(2),
        extra=rng.uniform(0.0, 0.01, n),
        multiplier=rng.uniform(0.5, 2.0, n),
        log_wrong=np.full(n, -20.0),
    )
    fit = LaplaceFit(0.0, np.array([0.1, -0.05]), np.log(0.15), np.array([0.08, 0.2]))
    limited, declared = rng.random(n) < 0.7, rng.random(n) < 0.3
    edges = Edges(
        leave=np.full(n, -9.0),
        leave_sd=np.zeros(n),
        detected=rng.normal(-0.7, 0.2, n),
        detected_sd=rng.uniform(0.0, 0.1, n),
        has_limit=limited | declared,
    )
    known = edges._replace(has_limit=declared)
    variance = rng.uniform(0.0, 0.02, n)
    wanted = 0.0
    for i in np.flatnonzero(limited & ~declared):
        middle = design.constant[i] + design.x[i] @ fit.coefficients
        total = (0.15 * design.multiplier[i]) ** 2 + design.extra[i]
        total += max(edges.detected_sd[i] ** 2, variance[i])
        total += 0.08**2 * (path[i] >= 0) + 0.2**2 * lone[1, i]
        shape = stats.t(4) if student else stats.norm()
        wanted -= shape.logcdf((edges.detected[i] - middle) / np.sqrt(total))
    assert limit_by_chance(edges, known, design, fit, variance, student) == pytest.approx(wanted)
