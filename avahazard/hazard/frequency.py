"""How often which volumes come down a path: by records, or by a table of the user."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy.interpolate import make_interp_spline

from avahazard.arrays import Floats
from avahazard.hazard import extremes
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
    WINDOWS,
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
from avahazard.records.cells import plain_cells
from avahazard.records.collection import Records, of_path
from avahazard.records.conventions import UNKNOWN
from avahazard.records.errors import AvahazardError, RejectedRows, RowProblem, told_once
from avahazard.records.forms import spell
from avahazard.records.rows import ID, PLAIN, Name, Positive, Row, check_rows
from avahazard.records.sheet import read_tables
from avahazard.results.hazard import ReturnLevel

ENOUGH_MAXIMA = 30
"""Maxima, or excesses over the threshold, from which a path stands alone."""
N_DRAWS = 400
WINDOW_NOTES = dict(
    zip(WINDOWS.values(), (None, "data_window_to", "data_window_from", "data_window"), strict=True)
)
"""The note on where the observed years come from."""
USE_VOLUME = "Give the volume itself with --volume."


@dataclass(frozen=True, slots=True, eq=False)
class VolumeFrequency:
    """Posterior draws of one path's frequency, and in `method` where they come from.

    `pooled`: scale and shape lean on the other paths' records. It is known for return periods
    between `known_years`. `record` is that of the path, None with a table of the user's.
    """

    path_id: str
    draws: extremes.FrequencyDraws
    method: str
    pooled: bool
    known_years: tuple[float, float]
    record: VolumeRecord | None = None

    @property
    def source(self) -> Literal["records", "given"]:
        """The records of events, or a table of the user's."""
        return "given" if self.record is None else "records"

    def volumes(self) -> extremes.EventVolumes:
        """Rates and volumes of all avalanches, for the runout exceeded once in T years."""
        found = extremes.event_volumes(self.draws.rate, self.draws.rate_over, *self.draws.ends())
        return replace(found, seen_only=self.source == "records")


def fit_volume_frequency(
    region: RegionVolumes, path_id: str, rng: np.random.Generator, n_draws: int = N_DRAWS
) -> VolumeFrequency:
    """Posterior of the frequency of volumes of one path in its region (docs/theory/hazard.md).

    The logs of volumes are fitted. A path with under 30 maxima (or excesses) takes as prior of
    scale and shape the likelihood of the other paths' records, widened by how far paths differ
    (`regional_prior`). Raises `AvahazardError` where the path has no volume, where it has none over
    the threshold, or where no path of the region has 3.
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
    others = region.others(path_id, likelihood) if len(own) < ENOUGH_MAXIMA else None
    if others is not None and others.n_paths == 0:
        others = None
    if len(own) < FEWEST_TELLING and others is None:
        raise AvahazardError(
            f"Too few {what} for a return period: path {path_id} has {len(own)}, "
            "and no path has 3.",
            USE_VOLUME,
        )
    if len(own) > 1 and np.ptp(own) == 0.0 and others is None:
        raise AvahazardError(f"All {what} of path {path_id} are equal.", USE_VOLUME)
    error = region.error(path_id)
    prior = extremes.shape_prior(error)
    if others is not None:
        prior = extremes.regional_prior(others.likelihood, region.common_error)
    draws: extremes.FrequencyDraws
    if region.family == "gev":
        middle = float(region.recorded[path_id].log_volumes.mean())
        gev = extremes.gev_draws(own, prior, likelihood, n_draws, rng, error=error, middle=middle)
        empty = record.n_years - record.n_event_years
        draws = extremes.GevDraws(rng.beta(record.n_event_years + 0.5, empty + 0.5, n_draws), gev)
    else:
        scale, shape = extremes.gpd_draws(prior, likelihood, n_draws, rng)
        draws = _threshold_draws(record, region.threshold(path_id), scale, shape, rng)
    method, pooled = _words(region, record, own, others), others is not None
    return VolumeFrequency(path_id, draws, method, pooled, record.known_years, record)


def _threshold_draws(
    record: VolumeRecord, threshold: float, scale: Floats, shape: Floats, rng: np.random.Generator
) -> extremes.ThresholdDraws:
    """Rates with a Jeffreys prior of the Poisson, shares with one of the binomial."""
    n = len(scale)
    below = np.sort(record.log_volumes[record.log_volumes <= threshold])
    n_over = len(record.log_volumes) - len(below)
    weight = rng.dirichlet(np.ones(len(below)), n) if len(below) else np.zeros((n, 0))
    share = rng.beta(n_over + 0.5, len(below) + 0.5, n) if len(below) else np.ones(n)
    rate = rng.gamma(record.n_events + 0.5, 1.0 / record.n_years, n)
    return extremes.ThresholdDraws(rate, share, threshold, scale, shape, below, weight)


def return_volume(frequency: VolumeFrequency, return_period_years: float) -> ReturnLevel:
    """The volume that a year's largest exceeds with chance 1/T; refused where events are rarer."""
    period, observed = return_period_years, frequency.record
    if observed is not None:
        often = observed.n_event_years / observed.n_years
        if often * period <= 1:
            raise AvahazardError(
                f"Path {observed.path_id} has an event in {observed.n_event_years} of "
                f"{observed.n_years} years: no volume returns every {period:g} years.",
                f"Ask for a return period over {1 / often:.0f} years.",
            )
    log_volume = frequency.draws.log_volume(1.0 / period)
    low, middle, high = np.exp(np.quantile(log_volume, [0.05, 0.5, 0.95]))
    shortest, longest = frequency.known_years
    extrapolated = not shortest <= period <= longest
    return ReturnLevel(period, float(middle), float(low), float(high), extrapolated)


def _words(
    region: RegionVolumes, record: VolumeRecord, own: Floats, others: PooledPaths | None
) -> str:
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
    if others is not None:
        text += (
            f"; scale and shape with a prior from {counted(others.n_paths, 'other path')} "
            f"({counted(others.n_values, 'volume')})"
        )
    n = len(record.gaps)
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
            straight = make_interp_spline(self.log_volumes, self.log_rates, k=1)(log_volume)
            rates = np.exp(np.minimum(straight, self.log_rates[0]))
        return np.tile(rates, (N_DRAWS, 1))

    def log_volume(self, chance: float | Floats) -> Floats:
        """The volume of the rate of years with one or more."""
        return np.full(N_DRAWS, self._at_rate(np.log(-np.log1p(-chance))))

    def ends(self) -> tuple[float, float]:
        """From the first row to ten times the last one's period."""
        high = self._at_rate(self.log_rates[-1] - np.log(FARTHEST))
        return float(self.log_volumes[0]), float(high)

    def _at_rate(self, log_rate: float | Floats) -> Floats:
        """Log volumes, between the rows and past them."""
        if len(self.log_rates) == 1:
            return np.asarray(self.log_volumes[0])
        return np.asarray(
            make_interp_spline(self.log_rates[::-1], self.log_volumes[::-1], k=1)(log_rate)
        )


class ReturnVolumeRow(Row):
    """The volume of one return period on one path."""

    path_id: Name = Field(description=ID)
    return_period_years: Annotated[float, Field(gt=1, allow_inf_nan=False), PLAIN] = Field(
        description="a number of years over 1"
    )
    volume_m3: Positive = Field(description="a volume in m3, over 0")


def read_return_volumes(file: FilePath) -> dict[str, list[tuple[float, float]]]:
    """Rows of (return period in years, volume in m3) by path, in the order of the periods.

    Raises `AvahazardError` where the file cannot be read, and `RejectedRows` for rows that are
    not acceptable, such as a volume that is not over that of a shorter period.
    """
    problems: list[RowProblem] = []
    try:
        tables = read_tables(file, problems)
    except OSError as error:
        raise AvahazardError(
            f"The file {file} cannot be read: {error.strerror}.", "Name a CSV or .xlsx file."
        ) from error
    if len(tables) > 1:
        raise AvahazardError(
            f"The workbook {file} has {len(tables)} sheets with values.",
            "Leave one in it, or save that one as CSV.",
        )
    if not tables:
        raise RejectedRows(problems)
    table = plain_cells(spell(tables[0], (), problems), UNKNOWN, problems)
    by_path: dict[str, list[tuple[float, float, int]]] = {}
    for line, row in check_rows(ReturnVolumeRow, table.file, table.numbered(), problems):
        by_path.setdefault(row.path_id, []).append((row.return_period_years, row.volume_m3, line))
    for rows in by_path.values():
        rows.sort()
        for (years, before, _), (more_years, volume, line) in pairwise(rows):
            if more_years == years or volume <= before:
                accepted = f"a volume over {before:g}, that of {years:g} years; each period once"
                problems.append(RowProblem(str(file), line, "volume_m3", f"{volume:g}", accepted))
    if problems:
        raise RejectedRows(told_once(problems))
    if not by_path:
        columns = ", ".join(ReturnVolumeRow.model_fields)
        raise AvahazardError(f"The file {file} has no rows.", f"Its columns: {columns}.")
    return {key: [(years, volume) for years, volume, _ in rows] for key, rows in by_path.items()}


def table_frequency(path_id: str, rows: Sequence[tuple[float, float]]) -> VolumeFrequency:
    """The frequency of rows of (return period in years, volume in m3), both rising."""
    years = np.array([row[0] for row in rows])
    draws = TableDraws(
        np.log([extremes.annual_rate(period) for period in years]), np.log([row[1] for row in rows])
    )
    method = f"given: {len(rows)} volumes, {years[0]:g} to {years[-1]:g} years, taken as exact"
    known = float(years[0]), float(years[-1])
    return VolumeFrequency(path_id, draws, method, pooled=False, known_years=known)


def known_volumes(records: Records) -> list[DatedVolumes]:
    """What whole records tell of the volumes of their paths."""
    return [dated_volumes(path, of_path(records, path.path_id).events) for path in records.paths]


@dataclass(frozen=True, slots=True, eq=False)
class Frequencies:
    """Frequencies by path, fitted when asked for, or `refused`; or the rows of a `table`."""

    region: RegionVolumes
    refused: dict[str, AvahazardError]
    seed: int
    source: VolumeSource
    table: dict[str, list[tuple[float, float]]] | None
    trend: Trend

    def of(self, path_id: str) -> VolumeFrequency:
        """The frequency of a path. Raises `AvahazardError` where there is none."""
        if self.table is not None:
            if path_id not in self.table:
                raise AvahazardError(
                    f"The table {self.source.table} has no row of path {path_id}.",
                    "Add its return periods and volumes, or name other paths with --path.",
                )
            return table_frequency(path_id, self.table[path_id])
        if path_id in self.refused:
            raise self.refused[path_id]
        rng = generator(self.seed, "frequency", path_id)
        found = fit_volume_frequency(self.region, path_id, rng)
        year = self.source.as_of
        if year is None:
            return found
        draws = as_of(found.draws, self.trend, self.region.records[path_id], year, rng)
        return replace(found, draws=draws, method=f"{found.method}; as of {year}")

    def volumes(self, path_id: str, *, by_volume: bool) -> extremes.EventVolumes:
        """Rate and volumes of a path; its rate alone, if it has one, unless `by_volume`."""
        rate = None if by_volume else self.rate_alone(path_id)
        return rate or self.of(path_id).volumes()

    def rate_alone(self, path_id: str) -> extremes.EventVolumes | None:
        """The rate of a path by its record, for models to which volume does not matter; or None."""
        record = self.region.records.get(path_id)
        if record is None:
            return None
        rng = generator(self.seed, "rate", path_id)
        rate = rng.gamma(record.n_events + 0.5, 1.0 / record.n_years, N_DRAWS)
        if (year := self.source.as_of) is not None:
            rate *= rate_factor(self.trend, record, year, N_DRAWS, rng)
        alone = extremes.one_volume(extremes.ANY_VOLUME_M3, N_DRAWS)
        return replace(alone, rate=rate, seen_only=True)

    def notes(self, path_id: str) -> list[Note]:
        """Where the years of a path's rate are those of the data set, and trends over the years."""
        record = self.region.records.get(path_id)
        if record is None or self.table is not None:
            return []
        notes = self.trend.notes(self.source.as_of)
        key = WINDOW_NOTES[record.window]
        if key is None:
            return notes
        seasons = Note("of_winters" if record.seasons == "winters" else "of_years")
        first, last = record.first_year, record.last_year
        return [Note(key, seasons=seasons, first=first, last=last), *notes]

    def extrapolated(self, path_id: str, return_period: float) -> bool:
        """Whether a return period (years) is too long for what is known of a path."""
        rows = (self.table or {}).get(path_id)
        known = (rows[0][0], rows[-1][0]) if rows else self.region.records[path_id].known_years
        return not known[0] <= return_period <= known[1]


def volume_frequencies(
    known: Sequence[DatedVolumes], seed: int, source: VolumeSource | None = None
) -> Frequencies:
    """The frequencies of all paths. Raises `AvahazardError` for a file that cannot be read."""
    source = source or VolumeSource()
    window = data_window(known, source.year_starts)
    records: list[VolumeRecord] = []
    refused: dict[str, AvahazardError] = {}
    for own in known:
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
    if source.table is None:
        # Now, while every worker is free: each would look at all paths for itself.
        _ = region.together
    table = None if source.table is None else read_return_volumes(source.table)
    return Frequencies(region, refused, seed, source, table, trend)
