"""A recorded avalanche, and the speeds measured along it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from avahazard.records.path import Covariate

WINTER_STARTS = 10
"""Month in which a winter begins: it lasts from October to September."""


@dataclass(frozen=True, slots=True)
class Event:
    """One recorded avalanche, complete: defaults are filled in when it is read.

    Either `path_id` is set and the stop is `runout_x_m` or `runout_elevation_m` (both
    None only when `left_profile`), or `fall_height_m` and `runout_length_m` are set, or
    `h_over_l` alone, and there is no profile. `date` is ISO text, `YYYY` or `YYYY-MM-DD`.
    `release_elevation_m` None means the path's own, else the top of its profile.
    `runout_sigma_m` is the standard deviation of the record in the coordinate that was recorded
    (not of H/L alone); `volume_rel_sigma` that of log volume.
    """

    event_id: str
    path_id: str | None = None
    date: str | None = None
    runout_elevation_m: float | None = None
    runout_x_m: float | None = None
    runout_sigma_m: float = 10.0
    left_profile: bool = False
    release_elevation_m: float | None = None
    volume_m3: float | None = None
    deposit_length_m: float | None = None
    deposit_width_m: float | None = None
    deposit_thickness_m: float | None = None
    volume_rel_sigma: float = 0.5
    fall_height_m: float | None = None
    runout_length_m: float | None = None
    h_over_l: float | None = None
    covariates: Mapping[str, Covariate] = field(default_factory=dict)

    @property
    def in_ratio(self) -> bool:
        """Whether H/L is all that its record tells of where it stopped."""
        return self.path_id is None and self.fall_height_m is None

    @property
    def year(self) -> int | None:
        """Calendar year of the event, None without a date."""
        return int(self.date[:4]) if self.date else None

    def winter(self, starts: int = WINTER_STARTS) -> int | None:
        """The year in which its winter ends, or its year that begins in month `starts`.

        A date with a year alone belongs to the winter that ends in it; None without a date.
        """
        if self.date is None:
            return None
        month = int(self.date[5:7]) if len(self.date) >= 7 else 1
        return int(self.date[:4]) + (starts > 1 and month >= starts)


@dataclass(frozen=True, slots=True)
class Speed:
    """One measured speed; exactly one of `x_m`, `elevation_m` is set."""

    event_id: str
    speed_m_s: float
    speed_sigma_m_s: float
    x_m: float | None = None
    elevation_m: float | None = None
