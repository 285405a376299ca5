"""What limits of sight gain where nothing is fitted anew."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.criticism.screening.laplace_fit import Design, Edges, LaplaceFit
from avahazard.criticism.screening.limit_by_chance import limit_by_chance


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
        seen=rng.normal(-0.7, 0.2, n),
        seen_sd=rng.uniform(0.0, 0.1, n),
        has_limit=limited | declared,
    )
    known = edges._replace(has_limit=declared)
    variance = rng.uniform(0.0, 0.02, n)
    wanted = 0.0
    for i in np.flatnonzero(limited & ~declared):
        middle = design.constant[i] + design.x[i] @ fit.coefficients
        total = (0.15 * design.multiplier[i]) ** 2 + design.extra[i]
        total += max(edges.seen_sd[i] ** 2, variance[i])
        total += 0.08**2 * (path[i] >= 0) + 0.2**2 * lone[1, i]
        shape = stats.t(4) if student else stats.norm()
        wanted -= shape.logcdf((edges.seen[i] - middle) / np.sqrt(total))
    assert limit_by_chance(edges, known, design, fit, variance, student) == pytest.approx(wanted)
