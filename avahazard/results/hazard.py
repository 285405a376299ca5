"""Runouts, speeds, pressures and zones per path, and the frequency of volumes."""

from dataclasses import field
from typing import Any

from avahazard.notes import Note
from avahazard.results.base import ABSENT, Result, Rows


class Quantiles(Result):
    """5, 50 and 95 %."""

    q05: float
    q50: float
    q95: float


class Spread(Result):
    """Mean and quantiles in metres; None where they lie beyond the end of the profile.

    A quantile is a run among those drawn, never a value between two. The mean is that of the runs
    that stopped on the profile; it is None as soon as one of the quantiles is.
    """

    mean: float | None
    q05: float | None
    q50: float | None
    q95: float | None


class PlaceQuantiles(Result):
    """5, 50 and 95 % of a place in metres; None where it lies beyond the end of the profile."""

    q05: float | None
    q50: float | None
    q95: float | None


class MapPoint(Result):
    """A place on the map: `x` east (or longitude) and `y` north in the system `crs`."""

    x: float
    y: float
    crs: str


class FarthestRecord(Result):
    """The recorded stop farthest down; `runout_x_m` is None where it is beyond the profile."""

    runout_x_m: float | None
    date: str | None


class Design(Result):
    """The runout that avalanches of a path exceed once in T years, all volumes mixed.

    Quantiles are over the uncertainty that `interval` names, each of x and of elevation by
    itself: 5 % of elevation lies at 95 % of x where the ground falls all the way. `point` is the
    place of the median x; `records_beyond` it is None where the median is beyond the profile.
    """

    runout_x_m: PlaceQuantiles
    runout_elevation_m: PlaceQuantiles
    p_beyond: float
    point: MapPoint | None
    farthest_record: FarthestRecord | None
    records_beyond: int | None
    n_records: int
    interval: Note


class VolumeInterval(Result):
    """5 and 95 % of the posterior of a volume, m3."""

    q05: float
    q95: float


class RunoutInterval(Result):
    """A runout, and in `interval` what varies between its 5 and 95 %."""

    runout_x_m: Spread
    runout_elevation_m: Spread
    interval: Note


class YearlyChances(Result):
    """Chances a year along a path, 5, 50 and 95 % over the uncertainty of the parameters."""

    q05: tuple[float, ...]
    q50: tuple[float, ...]
    q95: tuple[float, ...]


class ReachChance(Result):
    """Chance that a year's avalanches pass places on the path (m)."""

    x_m: tuple[float, ...]
    elevation_m: tuple[float, ...]
    p_per_year: YearlyChances


class ModelRunout(Result):
    """What one of several models says, and its weight: its design runout, or that of the volume."""

    model: str
    weight: float
    runout_x_m: PlaceQuantiles


class HazardRow(Result):
    """What is expected on one path for a return period, or of a volume; lengths in m.

    `design` is the answer for a return period: the runout exceeded once in it. All else is the
    runout of avalanches of one volume, that of the period or a given one: `natural` holds all
    parameters at their middle, `parameters` is the posterior of the median runout. `reach`
    stands in the first row of a path with a rate. An average over models has each of them in
    `by_model`, and no `natural` or `parameters`.
    """

    path_id: str
    return_period_years: float | None
    volume_m3: float | None
    runout_x_m: Spread
    runout_elevation_m: Spread
    runout_x_steps_m: tuple[float | None, ...]
    interval: Note
    p_left_profile: float
    p_not_released: float
    n_draws: int
    n_nonpositive_friction: int
    design: Design | None = field(default=None, metadata=ABSENT)
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
    reach: ReachChance | None = field(default=None, metadata=ABSENT)
    by_model: tuple[ModelRunout, ...] | None = field(default=None, metadata=ABSENT)
    notes: tuple[Note, ...] = ()


def failed_document(path_id: str, reason: str) -> dict[str, Any]:
    """What stands in the place of the rows of a path that failed: its reason, and no numbers."""
    none = dict.fromkeys(("mean", "q05", "q50", "q95"))
    return {
        "path_id": path_id,
        "return_period_years": None,
        "volume_m3": None,
        "runout_x_m": none,
        "runout_elevation_m": none,
        "interval": None,
        "p_left_profile": None,
        "n_draws": 0,
        "failed": reason,
        "notes": [f"left out: {reason}"],
    }


class Hazard(Result):
    """The rows of all paths, with notes for people."""

    rows: Rows[HazardRow]
    notes: tuple[Note, ...] = ()


class ReturnLevel(Result):
    """The volume (m3) of a return period, with its posterior."""

    return_period_years: float
    volume_m3: float
    q05_m3: float
    q95_m3: float
    extrapolated: bool


class YearlyMaximum(Result):
    """A yearly largest volume (m3), and the return period of its rank."""

    return_period_years: float
    volume_m3: float


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


class Volumes(Result):
    """The entries of all paths, with notes for people."""

    rows: Rows[PathVolumes]
    notes: tuple[str, ...] = ()


class Density(Result):
    """Density of the flow, kg/m3."""

    mean: float
    sd: float


class ExceededHere(Result):
    """Speed (m/s) and pressure ρu² (kPa) that a year exceeds at a place with chance 1/T."""

    return_period_years: float
    extrapolated: bool
    speed_m_s: Quantiles
    pressure_kpa: Quantiles


class Place(Result):
    """A place of a path: how often it is reached, and what is exceeded there."""

    x_m: float
    elevation_m: float
    p_reach_per_year: float
    by_return_period: Rows[ExceededHere]


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


class PeriodDesign(Result):
    """The design runout of a return period, as `hazard` gives it."""

    return_period_years: float
    extrapolated: bool
    design: Design


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


class Zones(Result):
    """The entries of all paths, with notes for people."""

    rows: Rows[ZonedPath]
    notes: tuple[Note, ...] = ()
