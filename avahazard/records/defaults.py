"""What is assumed where a record says nothing (docs/data_forms.md)."""

from __future__ import annotations

VOLUME_REL_SIGMA = 0.5
H_OVER_L_REL_SIGMA = 0.05
"""Error of an H/L that is recorded alone, as a share of it: tables give two digits."""


def runout_sigma_m(year: int | None) -> float:
    """Standard deviation of a recorded runout in m: 25 before 1905, linear to 10 in 1975.

    An event without a year is taken as recent.
    """
    if year is None or year >= 1975:
        return 10.0
    if year < 1905:
        return 25.0
    return 25.0 - 15.0 * (year - 1905) / 70.0


def deposit_volume_m3(length_m: float, width_m: float, thickness_m: float) -> float:
    """Volume of a deposit, V = L W H / 2 in m3 (paper, section 2)."""
    return length_m * width_m * thickness_m / 2.0


def speed_sigma_m_s(speed_m_s: float) -> float:
    """Standard deviation of a measured speed in m/s: a tenth of it, at least 1."""
    return max(1.0, 0.1 * speed_m_s)
