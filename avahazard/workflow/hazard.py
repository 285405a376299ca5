"""Design runouts and runouts of volumes per path, by a stored model."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from avahazard.hazard.frequencies import volume_frequencies
from avahazard.hazard.volume_source import VolumeSource
from avahazard.results.base import Report, Rows, silent
from avahazard.results.hazard import Hazard, HazardRow, failed_document
from avahazard.store.results import BOUNDS, read_run
from avahazard.store.session import reading
from avahazard.workflow.hazard_notes import RowNotes, model_notes
from avahazard.workflow.hazard_unit import HazardUnit, hazard_of_path
from avahazard.workflow.requests import HazardRequest
from avahazard.workflow.stored.by_path import PathRun, run_paths, went_on
from avahazard.workflow.stored.own_effects import own_effects
from avahazard.workflow.stored.path_unit import PathWork
from avahazard.workflow.stored.region_fit import RegionFit, load_region_fit

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


def hazard(database: str, name: str, request: HazardRequest, report: Report = silent) -> Hazard:
    """Compute and store the runout of paths; all rows at once (see `run_hazard`)."""
    run = run_hazard(database, name, request, report)
    return Hazard(Rows(run.rows()), run.notes)


def run_hazard(
    database: str,
    name: str,
    request: HazardRequest,
    report: Report = silent,
) -> HazardRun:
    """Compute and store the runout of paths.

    One row for each path and each return period, with its design runout, or volume, sorted by
    path; paths without what a return period needs are left out with their reason. Rows are stored
    as they come; the same call goes on where it was interrupted.

    Raises:
        AvahazardError: there is no such model or path, `effect_files` are not those that the
            model was made with, a
            file of `source` cannot be read, or no path has what a return period needs.
    """
    stored, path_ids, work = hazard_work(database, name, request)
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
    database: str, name: str, request: HazardRequest
) -> tuple[RegionFit, list[str], PathWork[HazardUnit]]:
    """The model, the paths to run, and what is done on each. Raises as `run_hazard`."""
    periods, sizes = tuple(request.return_periods), tuple(request.volumes)
    if not periods and not sizes:
        periods = (DEFAULT_RETURN_PERIOD,)
    n_draws, seed, source = request.draws, request.seed, request.source
    own = own_effects(database, name, request.effect_files)
    stored = load_region_fit(database, name, own)
    path_ids = stored.paths_to_run(request.paths)
    unit = HazardUnit.of(
        stored,
        volume_frequencies(stored.survey.volumes, seed, source) if periods else None,
        periods,
        sizes,
        n_draws,
        seed,
    )
    settings = {
        "return_periods": list(periods),
        "volumes": list(sizes),
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
