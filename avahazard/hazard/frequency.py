"""How often which volumes come down a path: by records, by a table of the user, or by snowfall."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.extremes import (
    ANY_VOLUME_M3,
    EventVolumes,
    FrequencyDraws,
    Gev,
    GevDraws,
    ThresholdDraws,
    annual_rate,
    event_volumes,
    gev_draws,
    gev_likelihood,
    gpd_draws,
    one_volume,
    regional_prior,
    shape_prior,
)
from avahazard.hazard.frequency_files import read_return_volumes, read_snow_depths
from avahazard.hazard.trend import (
    FEWEST_RECORDS,
    LEAST_WINTERS,
    Trend,
    as_of,
    fit_trend,
    rate_factor,
)
from avahazard.hazard.volume_records import (
    FEWEST_TELLING,
    DatedVolumes,
    PooledPaths,
    RegionVolumes,
    VolumeRecord,
    data_window,
    dated_volumes,
    region_of,
    volume_record,
)
from avahazard.hazard.volume_source import VolumeSource
from avahazard.inference.seeds import generator
from avahazard.notes import Note, counted
from avahazard.records.collection import Event, Path, Records, of_path
from avahazard.records.errors import AvahazardError
from avahazard.results.hazard import ReturnLevel

ENOUGH_MAXIMA = 30
"""Maxima, or excesses over the threshold, from which a path stands alone."""
N_DRAWS = 400
USE_VOLUME = "Give the volume itself with --volume."


@dataclass(frozen=True, slots=True, eq=False)
class VolumeFrequency:
    """Posterior draws of one path's frequency, and in `method` where they come from.

    `pooled`: scale and shape lean on the other paths' records. `longest_years`: past twice as
    many, or past the ends of a table in `table_years`, a return period is an extrapolation.
    `source`: the records of events, a table of the user, or snowfall.
    """

    path_id: str
    draws: FrequencyDraws
    method: str
    pooled: bool
    record: VolumeRecord | None = None
    longest_years: float = np.inf
    table_years: tuple[float, float] | None = None
    source: Literal["records", "given", "snow"] = "records"

    def extrapolated(self, return_period_years: float) -> bool:
        """Whether the record or the table does not reach to this return period."""
        if self.table_years is not None:
            first, last = self.table_years
            return not first <= return_period_years <= last
        return return_period_years > 2 * self.longest_years

    def volumes(self) -> EventVolumes:
        """Rates and volumes of all avalanches, for the runout exceeded once in T years."""
        low, high = self.draws.ends()
        found = event_volumes(self.draws.rate, self.draws.rate_over, low, high)
        return replace(found, seen_only=self.source == "records")


def fit_volume_frequency(
    region: RegionVolumes, path_id: str, rng: np.random.Generator, n_draws: int = N_DRAWS
) -> VolumeFrequency:
    """Posterior of the frequency of volumes of one path in its region.

    On their own scale volumes span decades and a GEV or Pareto of them has neither mean nor
    variance; their logs are near Gumbel or exponential, and are what is fitted. The prior is flat
    in location and log scale and weak on the shape. A path with under 30 maxima (or excesses)
    takes as prior of scale and shape the likelihood of the other paths' records, widened by how
    far paths differ (`regional_prior`). Raises `AvahazardError` where the path has no volume,
    where it has none over the threshold, or where no path of the region has 3.
    """
    record = region.records[path_id]
    if not len(record.log_volumes):
        raise AvahazardError(f"No dated event of path {path_id} has a volume.", USE_VOLUME)
    own = region.sample(path_id)
    what = "yearly maxima" if region.family == "gev" else "volumes over the threshold"
    if not len(own):
        raise AvahazardError(
            f"Path {path_id} has no volume over the threshold.", "Give a smaller --threshold."
        )
    likelihood = region.likelihood(path_id)
    others = region.others(path_id, likelihood) if len(own) < ENOUGH_MAXIMA else PooledPaths()
    pooled = others.n_paths > 0
    if len(own) < FEWEST_TELLING and not pooled:
        raise AvahazardError(
            f"Too few {what} for a return period: path {path_id} has {len(own)}, "
            "and no path has 3.",
            USE_VOLUME,
        )
    if len(own) > 1 and np.ptp(own) == 0.0 and not pooled:
        raise AvahazardError(f"All {what} of path {path_id} are equal.", USE_VOLUME)
    error = region.error(path_id)
    prior = shape_prior(error=error)
    if pooled:
        prior = regional_prior(others.likelihood, region.error())
    draws: FrequencyDraws
    if region.family == "gev":
        middle = float(region.recorded[path_id].log_volumes.mean())
        gev = gev_draws(own, prior, likelihood, n_draws, rng, error=error, middle=middle)
        empty = record.n_years - record.n_event_years
        draws = GevDraws(rng.beta(record.n_event_years + 0.5, empty + 0.5, n_draws), gev)
    else:
        scale, shape = gpd_draws(prior, likelihood, n_draws, rng)
        draws = _threshold_draws(record, region.threshold(path_id), scale, shape, rng)
    return VolumeFrequency(
        path_id=path_id,
        draws=draws,
        method=_words(region, record, own, others),
        pooled=pooled,
        record=record,
        longest_years=record.n_years,
    )


def _threshold_draws(
    record: VolumeRecord, threshold: float, scale: Floats, shape: Floats, rng: np.random.Generator
) -> ThresholdDraws:
    """Rates with a Jeffreys prior of the Poisson, shares with one of the binomial."""
    n = len(scale)
    below = np.sort(record.log_volumes[record.log_volumes <= threshold])
    n_over = len(record.log_volumes) - len(below)
    weight = rng.dirichlet(np.ones(len(below)), n) if len(below) else np.zeros((n, 0))
    share = rng.beta(n_over + 0.5, len(below) + 0.5, n) if len(below) else np.ones(n)
    rate = rng.gamma(record.n_events + 0.5, 1.0 / record.n_years, n)
    return ThresholdDraws(rate, share, threshold, scale, shape, below, weight)


def return_volume(frequency: VolumeFrequency, return_period_years: float) -> ReturnLevel:
    """The volume that a year's largest avalanche exceeds with chance 1/T.

    Raises `AvahazardError` where events are rarer than T.
    """
    period = return_period_years
    observed = frequency.record if frequency.source == "records" else None
    if observed is not None and observed.event_year_chance * period <= 1:
        raise AvahazardError(
            f"Path {observed.path_id} has an event in {observed.n_event_years} of "
            f"{observed.n_years} years: no volume returns every {period:g} years.",
            f"Ask for a return period over {1 / observed.event_year_chance:.0f} years.",
        )
    low, middle, high = np.exp(
        np.quantile(frequency.draws.log_volume(1.0 / period), [0.05, 0.5, 0.95])
    )
    return ReturnLevel(
        return_period_years=period,
        volume_m3=float(middle),
        q05_m3=float(low),
        q95_m3=float(high),
        extrapolated=frequency.extrapolated(period),
    )


def _words(region: RegionVolumes, record: VolumeRecord, own: Floats, others: PooledPaths) -> str:
    """How the volume of a return period is found, in one sentence."""
    if region.family == "gev":
        kind = "winter" if record.seasons == "winters" else "yearly"
        text = f"GEV of log {kind} maxima, {len(own)} maxima"
    else:
        threshold = float(f"{np.exp(region.threshold(record.path_id)):.3g}")
        given = "given" if region.threshold_m3 is not None else "the median"
        text = (
            f"generalised Pareto of log volume over {threshold:.0f} m3 ({given}), "
            f"{len(own)} excesses"
        )
    text += ", posterior"
    if others.n_paths:
        text += (
            f"; scale and shape with a prior from {counted(others.n_paths, 'other path')} "
            f"({counted(others.n_values, 'volume')})"
        )
    n = record.n_unobserved
    unobserved = f", {counted(n, record.seasons[:-1])} not observed" if n else ""
    text += (
        f"; {counted(record.n_events, 'record')} over {record.seasons} {record.first_year} to "
        f"{record.last_year} ({record.window}{unobserved}): {record.events_per_year:.3g} a year"
    )
    if record.n_left_out:
        text += f"; {record.n_left_out} undated or outside these years left out"
    return text


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

    def log_volume(self, chance: float | Floats) -> Floats:
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


FEWEST_WINTERS = 10
DEPTH_SHAPE, DEPTH_SHAPE_SD = 0.0, 0.15
"""Weak prior of the shape of yearly largest three-day depths."""
LEAST_DEPTH_M = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class SnowfallDraws:
    """Yearly largest depths as `gev` (m); a volume is `m3_per_m` times a depth.

    The year's avalanche releases the year's depth: a volume comes as often as its depth. But no
    more avalanches come than the path's `rate` `[n]`.
    """

    gev: Gev
    m3_per_m: float
    rate: Floats

    def rate_over(self, log_volume: Floats) -> Floats:
        """Of a Poisson process whose yearly maxima are those depths, at most `rate`."""
        exceeded = self.gev.exceedance(np.exp(log_volume) / self.m3_per_m)
        with np.errstate(divide="ignore"):
            return np.minimum(-np.log1p(-exceeded), self.rate[:, None])

    def log_volume(self, chance: float | Floats) -> Floats:
        """The depth that a year exceeds with this chance, as a volume."""
        depth = np.maximum(self.gev.quantile(1.0 - chance), LEAST_DEPTH_M)
        return np.asarray(np.log(depth * self.m3_per_m))

    def ends(self) -> tuple[float, float]:
        """From depths that most years exceed to those of 10,000 years."""
        middle = np.quantile(self.log_volume(0.98), 0.2)
        return float(middle), float(np.quantile(self.log_volume(1e-4), 0.9))


def snowfall_frequency(
    path_id: str,
    depths_m: Floats,
    release_area_m2: float,
    density_ratio: float,
    record: VolumeRecord | None,
    rng: np.random.Generator,
) -> VolumeFrequency:
    """Frequency from the largest three-day snow depth of each winter (m) `[n_winters]`.

    V = depth · release area · `density_ratio` (density of the release over that of the deposit).
    The rate is that of `record`, or one avalanche a year without one. Raises `AvahazardError`
    with under 10 winters, or where all are equal.
    """
    if len(depths_m) < FEWEST_WINTERS or np.ptp(depths_m) == 0.0:
        raise AvahazardError(
            f"{len(depths_m)} winters of snow depth are too few for path {path_id}, "
            "or all are equal.",
            f"Give the largest three-day depth of {FEWEST_WINTERS} winters at least.",
        )
    # The grid's scales are those of logs: depths are brought to a spread of one.
    unit = float(np.std(depths_m))
    sample = depths_m / unit
    prior = shape_prior(DEPTH_SHAPE, DEPTH_SHAPE_SD)
    drawn = gev_draws(sample, prior, gev_likelihood(sample), N_DRAWS, rng)
    gev = Gev(drawn.shape, drawn.location * unit, drawn.scale * unit)
    rate = np.ones(N_DRAWS)
    if record is not None:
        rate = rng.gamma(record.n_events + 0.5, 1.0 / record.n_years, N_DRAWS)
    text = (
        f"GEV of three-day snow depth, {len(depths_m)} winters, posterior; "
        f"{release_area_m2:.4g} m2 of release, density ratio {density_ratio:g}"
    )
    if record is None:
        text += "; one avalanche a year, for want of a record"
    return VolumeFrequency(
        path_id=path_id,
        draws=SnowfallDraws(gev, release_area_m2 * density_ratio, rate),
        method=text,
        pooled=False,
        record=record,
        longest_years=len(depths_m),
        source="snow",
    )


RELEASE_AREA = "release_area_m2"
"""The column of paths that snowfall is made a volume by."""


@dataclass(frozen=True, slots=True)
class KnownVolumes:
    """What the records of paths tell of their volumes, gathered piece by piece.

    `areas` are release areas (m2) of paths that state one over 0.
    """

    paths: list[DatedVolumes] = field(default_factory=list)
    areas: dict[str, float] = field(default_factory=dict)

    def add(self, path: Path, events: Sequence[Event]) -> None:
        """Add a path, given all its events."""
        self.paths.append(dated_volumes(path, events))
        area = path.covariates.get(RELEASE_AREA)
        if isinstance(area, float | int) and area > 0.0:
            self.areas[path.path_id] = float(area)


def known_volumes(records: Records) -> KnownVolumes:
    """What whole records tell of the volumes of their paths."""
    known = KnownVolumes()
    for path in records.paths:
        known.add(path, of_path(records, path.path_id).events)
    return known


@dataclass(frozen=True, slots=True, eq=False)
class Frequencies:
    """Frequencies of volumes by path, fitted when they are asked for; `refused` says why not.

    `table` and `depths` are what the files of `source` hold, None without them; `areas` (m2) the
    release areas of paths that have one.
    """

    region: RegionVolumes
    refused: dict[str, AvahazardError]
    seed: int
    source: VolumeSource
    table: dict[str, list[tuple[float, float]]] | None
    depths: dict[str | None, Floats] | None
    areas: dict[str, float]
    trend: Trend
    fitted: dict[str, VolumeFrequency] = field(default_factory=dict)

    def of(self, path_id: str) -> VolumeFrequency:
        """The frequency of a path. Raises `AvahazardError` where there is none."""
        if path_id not in self.fitted:
            rng = generator(self.seed, "frequency", path_id)
            if self.table is not None:
                found = self._of_table(path_id, self.table)
            elif self.depths is not None:
                found = self._of_snow(path_id, self.depths, rng)
            elif path_id in self.refused:
                raise self.refused[path_id]
            else:
                found = fit_volume_frequency(self.region, path_id, rng)
                if (year := self.source.as_of) is not None and found.record is not None:
                    draws = as_of(found.draws, self.trend, found.record, year, rng)
                    found = replace(found, draws=draws, method=f"{found.method}; as of {year}")
            self.fitted[path_id] = found
        return self.fitted[path_id]

    def _of_table(
        self, path_id: str, table: dict[str, list[tuple[float, float]]]
    ) -> VolumeFrequency:
        if path_id not in table:
            raise AvahazardError(
                f"The table {self.source.table} has no row of path {path_id}.",
                "Add its return periods and volumes, or name other paths with --path.",
            )
        return table_frequency(path_id, table[path_id])

    def _of_snow(
        self, path_id: str, depths: dict[str | None, Floats], rng: np.random.Generator
    ) -> VolumeFrequency:
        if path_id not in self.areas:
            raise AvahazardError(
                f"Path {path_id} has no {RELEASE_AREA}.",
                "Add this column to paths.csv and import it with --update.",
            )
        own = depths.get(path_id, depths.get(None))
        if own is None:
            raise AvahazardError(
                f"The file {self.source.snowfall} has no snow depth for path {path_id}.",
                "Add its rows, or rows without a path_id, which hold for all.",
            )
        record = self.region.records.get(path_id)
        ratio = self.source.density_ratio
        return snowfall_frequency(path_id, own, self.areas[path_id], ratio, record, rng)

    def rate_alone(self, path_id: str) -> EventVolumes | None:
        """The rate of a path by its record, for models to which volume does not matter.

        None where the path has no record.
        """
        record = self.region.records.get(path_id)
        if record is None:
            return None
        rng = generator(self.seed, "rate", path_id)
        rate = rng.gamma(record.n_events + 0.5, 1.0 / record.n_years, N_DRAWS)
        if (year := self.source.as_of) is not None:
            rate *= rate_factor(self.trend, record, year, N_DRAWS, rng)
        return replace(one_volume(ANY_VOLUME_M3, N_DRAWS), rate=rate, seen_only=True)

    def notes(self, path_id: str) -> list[Note]:
        """Where the years of a path's rate are those of the data set, and trends over the years."""
        record = self.region.records.get(path_id)
        if record is None or self.table is not None:
            return []
        notes = [] if self.depths is not None else self.trend.notes(self.source.as_of)
        if record.own_years:
            return notes
        seasons = Note("of_winters" if record.seasons == "winters" else "of_years")
        first, last = record.first_year, record.last_year
        return [Note("data_window", seasons=seasons, first=first, last=last), *notes]

    def extrapolated(self, path_id: str, return_period: float) -> bool:
        """Whether a return period (years) is too long for what is known of a path."""
        try:
            return self.of(path_id).extrapolated(return_period)
        except AvahazardError:
            # A rate alone.
            return return_period > 2 * self.region.records[path_id].n_years


def volume_frequencies(
    known: KnownVolumes, seed: int, source: VolumeSource | None = None
) -> Frequencies:
    """The frequencies of all paths. Raises `AvahazardError` for a file that cannot be read."""
    source = source or VolumeSource()
    window = data_window(known.paths, source.year_starts)
    records: list[VolumeRecord] = []
    refused: dict[str, AvahazardError] = {}
    for own in known.paths:
        try:
            records.append(volume_record(own, window, source.year_starts))
        except AvahazardError as error:
            refused[own.path_id] = error.with_traceback(None)
    trend = fit_trend(records)
    if source.as_of is not None and trend.rate is None:
        raise AvahazardError(
            "The records are too few for a trend over the years.",
            f"Omit --as-of: it needs {FEWEST_RECORDS} dated records in {LEAST_WINTERS} winters.",
        )
    region = region_of(records, source.family, source.threshold_m3)
    if source.table is None and source.snowfall is None:
        # Now, while every worker is free: each would look at all paths for itself.
        region.together()
    return Frequencies(
        region=region,
        refused=refused,
        seed=seed,
        source=source,
        table=None if source.table is None else read_return_volumes(source.table),
        depths=None if source.snowfall is None else read_snow_depths(source.snowfall),
        areas=known.areas,
        trend=trend,
    )
