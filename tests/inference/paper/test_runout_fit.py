"""The compiled sum of squares against its slow twin."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.model.laws import LAWS, law
from avahazard.inference.paper.runout_fit import runout_records, squared_residuals
from avahazard.records.errors import AvahazardError
from tests.inference import naive
from tests.inference.paper.regression import line_records
from tests.inference.worlds import MU, MU_MIN, MU_STEP, runouts


@pytest.mark.parametrize("name", [n for n, one in LAWS.items() if one.form])
def test_sum_of_squares_equals_the_slow_twin(name: str) -> None:
    volume, runout, table, stop_y = runouts("exponential", [0.5, 1e-6], 100.0, 37, 1)
    item = law(name)
    records = runout_records(item, volume, runout, table, stop_y, MU_MIN, MU_STEP)
    rng = np.random.default_rng(2)
    place = np.empty(37)
    for wide in (1.0, 5.0):  # five prior sds: frictions off both ends of the tables too
        for u in rng.normal(item.prior_mean, wide * item.prior_sd, (40, item.prior_mean.size)):
            slow = naive.squared_residuals(u, item, volume, runout, table, stop_y, MU)
            assert squared_residuals(u, records, place) == pytest.approx(slow, rel=1e-8)


def test_without_tables_it_is_a_line() -> None:
    rng = np.random.default_rng(3)
    x, y = rng.normal(size=(2, 20))
    ours = squared_residuals(np.array([0.4, -1.3]), line_records(x, y), np.empty(20))
    assert ours == pytest.approx(np.sum((y - 0.4 - 1.3 * x) ** 2))


def test_gaps_are_refused() -> None:
    volume, runout, table, stop_y = runouts("constant", [0.5], 100.0, 5, 1)
    broken = stop_y.copy()
    broken[1, 3] = np.nan
    with pytest.raises(AvahazardError, match="gaps"):
        runout_records(law("constant"), volume, runout, table, broken, MU_MIN, MU_STEP)
    volume[2] = 0.0
    with pytest.raises(AvahazardError, match="positive volume"):
        runout_records(law("constant"), volume, runout, table, stop_y, MU_MIN, MU_STEP)
