"""The α-β runout of the stored paths."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Any

import numpy as np

from avahazard.effects.site import recorded_stops, release_place
from avahazard.hazard.alpha_beta import (
    BY_NAME,
    REGRESSIONS,
    AlphaBeta,
    Regression,
    alpha_beta_runouts,
)
from avahazard.notes import Note
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import find_path, find_profile
from avahazard.records.path import Path
from avahazard.results.base import Rows
from avahazard.results.hazard import HazardRow
from avahazard.results.terrain import TerrainRunout
from avahazard.store.records import load_records
from avahazard.store.results import BOUNDS, latest_documents, load_model
from avahazard.store.session import reading
from avahazard.workflow.requests import AlphaBetaRequest

SAME_PLACE_M = 20.0
"""AvaFrame's β-points that lie no farther apart are one place: two of its steps."""


BY_DEFAULT = AlphaBetaRequest()


def alpha_beta_paths(
    database: str, path_id: str | None = None, request: AlphaBetaRequest = BY_DEFAULT
) -> Rows[TerrainRunout]:
    """Return the α-β runout, for one path or all that have a profile.

    By the regressions that the request names, else `hazard.alpha_beta.REGRESSIONS`. Raises
    `AvahazardError` where the database, the path, its profile, a regression, or the model or its
    bounds are missing, or `plot` is not the name of a picture.
    """
    by, model, plot = request.by, request.model, request.plot
    unknown = [name for name in by if name not in BY_NAME]
    if unknown:
        raise AvahazardError(
            f"There are no α-β coefficients '{unknown[0]}'.", f"There are {', '.join(BY_NAME)}."
        )
    regressions = tuple(BY_NAME[name] for name in by) or REGRESSIONS
    with reading(database) as session:
        records = load_records(session)
        bounds: list[dict[str, Any]] | None = []
        if model is not None:
            load_model(session, model)
            bounds = latest_documents(session, BOUNDS, model)
    if bounds is None:
        raise AvahazardError(
            f"No bounds by {model} are stored.", f"Make them first: avahazard hazard {model}"
        )
    paths = _paths(records, path_id)
    found = [(path, *_runouts(records, path, regressions)) for path in paths]
    if plot is not None:
        _draw(plot, records, found, [HazardRow.from_dict(row) for row in bounds])
    return Rows(_row(path, smooth, one) for path, smooth, both in found for one in both)


def _runouts(
    records: Records, path: Path, regressions: tuple[Regression, ...]
) -> tuple[SmoothProfile, tuple[AlphaBeta, ...]]:
    profile = find_profile(records, path)
    smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    release_x = release_place(smooth, path.release_elevation_m)
    return smooth, alpha_beta_runouts(profile.x_m, profile.y_m, smooth, release_x, regressions)


def _paths(records: Records, path_id: str | None) -> list[Path]:
    if path_id is not None:
        return [find_path(records, path_id)]
    with_profile = {profile.path_id for profile in records.profiles}
    paths = [path for path in records.paths if path.path_id in with_profile]
    if not paths:
        raise AvahazardError(
            "There are no paths with a profile.", "Import paths.csv and profiles.csv first."
        )
    return paths


def _row(path: Path, smooth: SmoothProfile, found: AlphaBeta) -> TerrainRunout:
    return TerrainRunout(
        path_id=path.path_id,
        coefficients=found.regression.name,
        source=found.regression.source,
        status=found.status,
        release_x_m=found.release_x,
        beta_deg=found.beta_deg,
        beta_x_m=found.beta_x,
        alpha_deg=found.alpha_deg,
        alpha_sd_deg=found.regression.sd_deg,
        runout_x_m=found.runout_x,
        runout_elevation_m=(
            None if found.runout_x is None else float(smooth.height(found.runout_x))
        ),
        runout_x_low_m=found.runout_low_x,
        runout_x_high_m=found.runout_high_x,
        notes=_notes(path, found),
    )


def _notes(path: Path, found: AlphaBeta) -> tuple[Note, ...]:
    notes = _of_points(path, found) if found.regression.first_step else ()
    if found.status == "no_beta_point":
        return (Note("no_beta_point", path.path_id), *notes)
    if found.further_beta_x:
        places = [f"{x:.0f}" for x in found.further_beta_x]
        return (Note("flattens_again", path.path_id, places=places),)
    return notes


def _of_points(path: Path, found: AlphaBeta) -> tuple[Note, ...]:
    """AvaFrame's β-point is one of the points, errors and all: say where these decide it."""
    smoothed, beta = found.smoothed_beta_x, found.beta_x
    if smoothed is None and beta is not None:
        return (Note("beta_of_points_alone", path.path_id),)
    if smoothed is None or (beta is not None and abs(smoothed - beta) <= SAME_PLACE_M):
        return ()
    return (Note("beta_of_points", path.path_id, x=smoothed),)


def _unlike(row: HazardRow) -> float:
    """How far a row is from what the regressions are of: the runout of about 100 years."""
    period = row.return_period_years
    return np.inf if period is None else abs(float(np.log(period / 100.0)))


def _draw(
    plot: FilePath,
    records: Records,
    found: list[tuple[Path, SmoothProfile, tuple[AlphaBeta, ...]]],
    bounds: list[HazardRow],
) -> None:
    from avahazard.report.path_pictures import DrawnPath, draw_alpha_beta  # noqa: PLC0415 (slow)

    rows = {row.path_id: row for row in sorted(bounds, key=_unlike, reverse=True)}
    events = {p.path_id: [e for e in records.events if e.path_id == p.path_id] for p, _, _ in found}
    draw_alpha_beta(
        plot,
        [
            DrawnPath(
                name=path.name or path.path_id,
                smooth=smooth,
                baseline=both,
                stop_x=recorded_stops(smooth, events[path.path_id]),
                row=rows.get(path.path_id),
            )
            for path, smooth, both in found
        ],
    )
