"""Runout per path, for volumes and return periods."""

from __future__ import annotations

from dataclasses import dataclass, field

from avahazard.results.base import ABSENT, Result, Rows


@dataclass(frozen=True, slots=True)
class Quantiles(Result):
    """5, 50 and 95 %."""

    q05: float
    q50: float
    q95: float


@dataclass(frozen=True, slots=True)
class Spread(Result):
    """Mean and quantiles in metres; None where they lie beyond the end of the profile.

    A quantile is a run among those drawn, never a value between two. The mean is that of the runs
    that stopped on the profile; it is None as soon as one of the quantiles is.
    """

    mean: float | None
    q05: float | None
    q50: float | None
    q95: float | None


@dataclass(frozen=True, slots=True)
class VolumeInterval(Result):
    """5 and 95 % of the posterior of a volume, m3."""

    q05: float
    q95: float


@dataclass(frozen=True, slots=True)
class RunoutInterval(Result):
    """A runout, and in `interval` what varies between its 5 and 95 %."""

    runout_x_m: Spread
    runout_elevation_m: Spread
    interval: str


@dataclass(frozen=True, slots=True)
class YearlyChances(Result):
    """Chances a year along a path, 5, 50 and 95 % over the uncertainty of the parameters."""

    q05: tuple[float, ...]
    q50: tuple[float, ...]
    q95: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ReachChance(Result):
    """Chance that a year's avalanches pass places on the path (m)."""

    x_m: tuple[float, ...]
    elevation_m: tuple[float, ...]
    p_per_year: YearlyChances


@dataclass(frozen=True, slots=True)
class HazardRow(Result):
    """The runout on one path of a volume, or of the volume of a return period; lengths in m.

    `natural` holds all parameters at their middle, `parameters` is the posterior of the median
    runout, `exceeded` the runout that a year exceeds with chance 1/T, all volumes mixed. `reach`
    stands in the first row of a path with a rate. Where the volume of a return period comes from
    is None for a volume that was given.
    """

    path_id: str
    return_period_years: float | None
    volume_m3: float | None
    runout_x_m: Spread
    runout_elevation_m: Spread
    runout_x_steps_m: tuple[float | None, ...]
    interval: str
    p_left_profile: float
    p_not_released: float
    n_draws: int
    n_nonpositive_friction: int
    volume_interval_m3: VolumeInterval | None = field(default=None, metadata=ABSENT)
    volume_method: str | None = field(default=None, metadata=ABSENT)
    volume_source: str | None = field(default=None, metadata=ABSENT)
    pooled: bool | None = field(default=None, metadata=ABSENT)
    extrapolated: bool | None = field(default=None, metadata=ABSENT)
    n_records: int | None = field(default=None, metadata=ABSENT)
    first_year: int | None = field(default=None, metadata=ABSENT)
    last_year: int | None = field(default=None, metadata=ABSENT)
    years_not_observed: int | None = field(default=None, metadata=ABSENT)
    years_from: str | None = field(default=None, metadata=ABSENT)
    events_per_year: float | None = field(default=None, metadata=ABSENT)
    natural: RunoutInterval | None = field(default=None, metadata=ABSENT)
    parameters: RunoutInterval | None = field(default=None, metadata=ABSENT)
    exceeded: RunoutInterval | None = field(default=None, metadata=ABSENT)
    reach: ReachChance | None = field(default=None, metadata=ABSENT)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Hazard(Result):
    """The rows of all paths, with notes for people."""

    rows: Rows[HazardRow]
    notes: tuple[str, ...] = ()
