"""The frequency of volumes per path."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.results.base import Result, Rows


@dataclass(frozen=True, slots=True)
class ReturnLevel(Result):
    """The volume (m3) of a return period, with its posterior."""

    return_period_years: float
    volume_m3: float
    q05_m3: float
    q95_m3: float
    extrapolated: bool


@dataclass(frozen=True, slots=True)
class YearlyMaximum(Result):
    """A yearly largest volume (m3), and the return period of its rank."""

    return_period_years: float
    volume_m3: float


@dataclass(frozen=True, slots=True)
class PathVolumes(Result):
    """The frequency of volumes of one path: the fit in words, its record, and return levels."""

    path_id: str
    method: str
    source: str
    pooled: bool
    n_records: int | None
    n_volumes: int | None
    first_year: int | None
    last_year: int | None
    years_not_observed: int | None
    events_per_year: float | None
    levels: Rows[ReturnLevel]
    maxima: Rows[YearlyMaximum]


@dataclass(frozen=True, slots=True)
class Volumes(Result):
    """The entries of all paths, with notes for people."""

    rows: Rows[PathVolumes]
    notes: tuple[str, ...] = ()
