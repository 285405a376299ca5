"""Design runouts and runouts of volumes per path, by a stored model."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from avahazard.hazard.frequencies import VolumeSource, volume_frequencies
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Report, Rows, silent
from avahazard.results.hazard import Hazard, HazardRow, failed_document
from avahazard.store.results import BOUNDS, read_run
from avahazard.store.session import reading
from avahazard.workflow.hazard_notes import RowNotes, model_notes
from avahazard.workflow.hazard_unit import HazardUnit, hazard_of_path
from avahazard.workflow.stored.by_path import PathRun, run_paths, went_on
from avahazard.workflow.stored.own_effects import own_effects
from avahazard.workflow.stored.path_unit import PathWork
from avahazard.workflow.stored.region_fit import RegionFit, load_region_fit

N_DRAWS = 20_000
DEFAULT_RETURN_PERIOD = 100.0


@dataclass(frozen=True, slots=True)
class HazardRun:
    """A run of `hazard` that is stored, with notes for people; `failed` are reasons by path."""

    database: str
    stored: PathRun
    n_rows: int
    notes: tuple[str, ...]
    failed: dict[str, str]

    def rows(self) -> Iterator[HazardRow]:
        """Its rows as the database has them, a few in memory at a time."""
        with reading(self.database) as session:
            for found in read_run(session, self.stored.run):
                yield from (HazardRow.from_dict(row) for row in found.documents)

    def documents(self) -> Iterator[dict[str, Any]]:
        """What `--json` prints: its rows, and in their place why a path failed."""
        with reading(self.database) as session:
            for found in read_run(session, self.stored.run):
                if found.failed is None:
                    yield from found.documents
                else:
                    yield failed_document(found.path_id, found.failed)


@dataclass(frozen=True, slots=True)
class HazardQuestion:
    """What `hazard` is asked: return periods (years), volumes (m3), and on which paths.

    With neither of the first two, a return period of 100 years. Paths are those named, or all with
    a profile. `source` says where the frequency of volumes comes from.
    """

    return_periods: Sequence[float] = ()
    volumes: Sequence[float] = ()
    paths: Sequence[str] = ()
    source: VolumeSource | None = None
    n_draws: int = N_DRAWS
    seed: int = 0
    effect_files: Sequence[FilePath] = ()


def hazard(database: str, name: str, *, report: Report = silent, **asked: Any) -> Hazard:
    """Compute and store the runout of paths; all rows at once (see `run_hazard`).

    `asked` are the fields of a `HazardQuestion`.
    """
    run = run_hazard(database, name, HazardQuestion(**asked), report)
    return Hazard(Rows(run.rows()), run.notes)


def run_hazard(
    database: str,
    name: str,
    question: HazardQuestion,
    report: Report = silent,
) -> HazardRun:
    """Compute and store the runout of paths.

    One row for each path and each return period, with its design runout, or volume, sorted by
    path; paths without what a return period needs are left out with their reason. Rows are stored
    as they come; the same call goes on where it was interrupted.

    Raises:
        AvahazardError: there is no such model or path, `effect_files` are not those that the
            model was made with, a volume is not over 0 or a return period not over 1 year, a
            file of `source` cannot be read, or no path has what a return period needs.
    """
    stored, path_ids, work = hazard_work(database, name, question)
    run = run_paths(database, stored, path_ids, work, report)
    of_model = model_notes(stored)
    told = RowNotes(of_model)
    failed: dict[str, str] = {}
    beyond: list[str] = []
    n_rows = 0
    with reading(database) as session:
        for found in read_run(session, run.run):
            beyond += found.notes
            if found.failed is not None:
                failed[found.path_id] = found.failed
            n_rows += len(found.documents)
            for row in found.documents:
                told.add(row)
    notes = [*of_model, *beyond, *(f"left out: {reason}" for reason in failed.values())]
    if run.n_before:
        notes.insert(0, went_on(run))
    return HazardRun(database, run, n_rows, (*notes, *told.in_short()), failed)


def hazard_work(
    database: str, name: str, question: HazardQuestion
) -> tuple[RegionFit, list[str], PathWork[HazardUnit]]:
    """The model, the paths to run, and what is done on each. Raises as `run_hazard`."""
    _check(question.volumes, "volume", "m3", 0.0)
    _check(question.return_periods, "return period", "years", 1.0)
    periods = tuple(dict.fromkeys(question.return_periods))
    sizes = tuple(dict.fromkeys(question.volumes))
    if not periods and not sizes:
        periods = (DEFAULT_RETURN_PERIOD,)
    n_draws, seed, source = question.n_draws, question.seed, question.source or VolumeSource()
    own = own_effects(database, name, question.effect_files)
    stored = load_region_fit(database, name, own)
    path_ids = stored.paths_to_run(question.paths)
    unit = HazardUnit.of(
        stored,
        volume_frequencies(stored.survey.volumes, seed, source) if periods else None,
        periods,
        sizes,
        n_draws,
        seed,
    )
    settings = {
        "return_periods": [float(period) for period in periods],
        "volumes": [float(volume) for volume in sizes],
        "n_draws": n_draws,
        "seed": seed,
        "source": source_settings(source),
    }
    return stored, path_ids, PathWork(BOUNDS, "Runout", hazard_of_path, unit, settings)


def source_settings(source: VolumeSource) -> dict[str, Any]:
    """Where volumes come from, files by what they hold."""
    settings = asdict(source)
    for key in ("table", "snowfall"):
        file = settings[key]
        if file is not None:
            settings[key] = hashlib.sha256(file.read_bytes()).hexdigest()
    return settings


def _check(values: Sequence[float], what: str, unit: str, least: float) -> None:
    for value in values:
        if not (np.isfinite(value) and value > least):
            raise AvahazardError(
                f"The {what} is {value:g}.", f"It must be a number of {unit} over {least:g}."
            )
