"""The frequency of volumes per path: the fit, return levels, and the records beside them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from avahazard.hazard.frequency import (
    Frequencies,
    VolumeFrequency,
    known_volumes,
    return_volume,
    volume_frequencies,
)
from avahazard.records.collection import find_path
from avahazard.records.errors import AvahazardError
from avahazard.report.picture import require_picture
from avahazard.request import many
from avahazard.results.base import Rows
from avahazard.results.hazard import PathVolumes, ReturnLevel, Volumes, YearlyMaximum
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.requests import VolumesRequest

RETURN_PERIODS = (10.0, 30.0, 100.0, 300.0)
CURVE = tuple(float(t) for t in np.geomspace(1.2, 1000.0, 60))


def volumes(database: str, request: VolumesRequest) -> Volumes:
    """The frequency of volumes of each path, all where none is named; nothing is stored.

    Periods that are shorter than the time between avalanches have no level. Raises `AvahazardError`
    where a path is unknown, no path has what is needed, a file of `source` cannot be read, or
    `plot` is not a picture's name.
    """
    paths: tuple[str, ...] = many(request.paths)
    wanted, plot = request.return_periods or RETURN_PERIODS, request.plot
    require_picture(plot)
    with reading(database) as session:
        records = load_records(session)
    named = [find_path(records, path_id).path_id for path_id in paths]
    frequencies = volume_frequencies(known_volumes(records), request.seed, request.source)
    entries, notes, refusals, curves = [], [], [], []
    for path_id in named or sorted(p.path_id for p in records.paths):
        try:
            frequency = frequencies.of(path_id)
        except AvahazardError as error:
            if named:
                raise
            refusals.append(error)
            notes.append(f"left out: {error.message}")
            continue
        entries.append(_entry(frequency, frequencies, wanted))
        curves.append(_levels(frequency, CURVE))
    if not entries:
        none = AvahazardError("There are no paths.", "Import paths.csv and events.csv first.")
        raise next(iter(refusals), none)
    if plot is not None:
        from avahazard.report.friction_pictures import draw_return_levels  # noqa: PLC0415

        draw_return_levels(plot, entries, curves)
    return Volumes(Rows(entries), tuple(notes))


def _entry(
    frequency: VolumeFrequency, frequencies: Frequencies, periods: Sequence[float]
) -> PathVolumes:
    record = frequency.record
    return PathVolumes(
        path_id=frequency.path_id,
        method=frequency.method,
        source=frequency.source,
        pooled=frequency.pooled,
        n_records=None if record is None else record.n_events,
        n_volumes=None if record is None else len(record.log_volumes),
        first_year=None if record is None else record.first_year,
        last_year=None if record is None else record.last_year,
        years_not_observed=None if record is None else record.n_unobserved,
        events_per_year=None if record is None else record.events_per_year,
        levels=_levels(frequency, periods),
        maxima=_maxima(frequencies, frequency.path_id),
    )


def _levels(frequency: VolumeFrequency, periods: Sequence[float]) -> Rows[ReturnLevel]:
    """The return levels that there are: events may be rarer than a short period."""
    found = []
    for period in periods:
        with suppress(AvahazardError):
            found.append(return_volume(frequency, period))
    return Rows(found)


def _maxima(frequencies: Frequencies, path_id: str) -> Rows[YearlyMaximum]:
    """The yearly largest volumes and the return periods of their rank, (n + 1) / rank."""
    record = frequencies.region.records.get(path_id)
    if record is None:
        return Rows()
    largest = np.sort(np.exp(record.log_maxima))[::-1]
    return Rows(
        YearlyMaximum((record.n_years + 1) / rank, float(volume))
        for rank, volume in enumerate(largest, 1)
    )
