"""Speed, pressure and zones along the paths."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.notes import Note
from avahazard.results.base import Result, Rows
from avahazard.results.hazard import Design, Quantiles


@dataclass(frozen=True, slots=True)
class Density(Result):
    """Density of the flow, kg/m3."""

    mean: float
    sd: float


@dataclass(frozen=True, slots=True)
class ExceededHere(Result):
    """Speed (m/s) and pressure ρu² (kPa) that a year exceeds at a place with chance 1/T."""

    return_period_years: float
    extrapolated: bool
    speed_m_s: Quantiles
    pressure_kpa: Quantiles


@dataclass(frozen=True, slots=True)
class Place(Result):
    """A place of a path: how often it is reached, and what is exceeded there."""

    x_m: float
    elevation_m: float
    p_reach_per_year: float
    by_return_period: Rows[ExceededHere]


@dataclass(frozen=True, slots=True)
class Zone(Result):
    """A zone from `from_x_m` to `to_x_m`; the quantiles are None beyond the profile."""

    zone: str
    color: str
    from_x_m: float
    to_x_m: float
    to_x_q05_m: float | None
    to_x_q95_m: float | None
    beyond: bool
    extrapolated: bool


@dataclass(frozen=True, slots=True)
class PeriodDesign(Result):
    """The design runout of a return period, as `hazard` gives it."""

    return_period_years: float
    extrapolated: bool
    design: Design


@dataclass(frozen=True, slots=True)
class ZonedPath(Result):
    """One path: its design runouts, its zones, the worst first, and what comes to its `places`.

    These run from the highest release to the end of the profile.
    """

    path_id: str
    limits: str
    density_kg_m3: Density
    release_x_m: float
    end_x_m: float
    interval: Note
    designs: Rows[PeriodDesign]
    places: Rows[Place]
    p_not_released: float
    zones: Rows[Zone]
    notes: tuple[Note, ...]


@dataclass(frozen=True, slots=True)
class Zones(Result):
    """The entries of all paths, with notes for people."""

    rows: Rows[ZonedPath]
    notes: tuple[Note, ...] = ()
