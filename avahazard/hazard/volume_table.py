"""Volumes of return periods that the user gives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.avalanches import annual_rate
from avahazard.hazard.volume_frequency import N_DRAWS, VolumeFrequency

FARTHEST = 10.0
"""How many times the longest return period of a table is looked past its end."""


@dataclass(frozen=True, slots=True, eq=False)
class TableDraws:
    """A table taken as exact: `log_rates` `[n_rows]` falling, `log_volumes` `[n_rows]` rising.

    Log volume is straight against log rate, past the ends too; a table of one row has one volume.
    What is smaller than the first row's volume is not known and counts for nothing.
    """

    log_rates: Floats
    log_volumes: Floats

    @property
    def rate(self) -> Floats:
        """The rate of the first row: `n` times the same, as nothing is uncertain."""
        return np.full(N_DRAWS, np.exp(self.log_rates[0]))

    def rate_over(self, log_volume: Floats) -> Floats:
        """Rates over log volumes; the first row's below it."""
        if len(self.log_rates) == 1:
            rates = np.where(log_volume < self.log_volumes[0], np.exp(self.log_rates[0]), 0.0)
        else:
            rates = np.exp(
                np.minimum(
                    _straight(log_volume, self.log_volumes, self.log_rates), self.log_rates[0]
                )
            )
        return np.tile(rates, (N_DRAWS, 1))

    def log_volume(self, chance: float) -> Floats:
        """The volume of the rate of years with one or more."""
        if len(self.log_rates) == 1:
            return np.full(N_DRAWS, self.log_volumes[0])
        rate = np.array([np.log(-np.log1p(-chance))])
        found = _straight(rate, self.log_rates[::-1], self.log_volumes[::-1])
        return np.full(N_DRAWS, found[0])

    def ends(self) -> tuple[float, float]:
        """From the first row to ten times the last one's period."""
        if len(self.log_rates) == 1:
            return float(self.log_volumes[0]), float(self.log_volumes[0])
        far = self.log_rates[-1:] - np.log(FARTHEST)
        high = _straight(far, self.log_rates[::-1], self.log_volumes[::-1])
        return float(self.log_volumes[0]), float(high[0])


def table_frequency(path_id: str, rows: Sequence[tuple[float, float]]) -> VolumeFrequency:
    """The frequency of rows of (return period in years, volume in m3), both rising."""
    years = np.array([row[0] for row in rows])
    draws = TableDraws(
        np.log([annual_rate(period) for period in years]), np.log([row[1] for row in rows])
    )
    return VolumeFrequency(
        path_id=path_id,
        draws=draws,
        method=f"given: {len(rows)} volumes, {years[0]:g} to {years[-1]:g} years, taken as exact",
        pooled=False,
        table_years=(float(years[0]), float(years[-1])),
        source="given",
    )


def _straight(x: Floats, xs: Floats, ys: Floats) -> Floats:
    """Piecewise linear through points with rising xs; past the ends the end pieces go on."""
    k = np.clip(np.searchsorted(xs, x) - 1, 0, len(xs) - 2)
    slope = (ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k])
    return np.asarray(ys[k] + slope * (x - xs[k]))
