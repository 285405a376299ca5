"""Values assumed where a record says nothing."""

from __future__ import annotations

import pytest

from avahazard.records import defaults


@pytest.mark.parametrize(
    ("year", "sigma"), [(None, 10), (1700, 25), (1904, 25), (1940, 17.5), (1975, 10), (2020, 10)]
)
def test_runout_sigma_by_year(year: int | None, sigma: float) -> None:
    assert defaults.runout_sigma_m(year) == pytest.approx(sigma)


def test_deposit_is_half_a_block() -> None:
    assert defaults.deposit_volume_m3(100, 20, 3) == 3000


def test_speed_sigma_is_a_tenth_but_a_metre_per_second() -> None:
    assert [defaults.speed_sigma_m_s(v) for v in (0.0, 5.0, 30.0)] == [1, 1, 3]
