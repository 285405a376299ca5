"""Predictive distributions of the runout of new events."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from avahazard.arrays import Floats
from avahazard.criticism.scoring.error_budget import error_budget
from avahazard.criticism.scoring.expected import expected_records
from avahazard.criticism.scoring.scores import record_pit, runout_scores, x_scores
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.model.observations import LENGTH, stated_release_sigma
from avahazard.inference.prediction import extrapolation, predict_stops, stops_over_releases, told
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.records.event import Event
from avahazard.records.reading import read_records
from avahazard.results.base import RATIO, Rows
from avahazard.results.comparison import PredictedEvent, Prediction, PredictionScores
from avahazard.workflow.compare import RECORD_DRAWS, coordinate_name, require_comparable
from avahazard.workflow.stored import load_stored, notes_of_fit, on_events

STOP_DRAWS = 2000
DENSITY_DRAWS = 500


def predict(
    database: str, name: str, file: Path, *, effect_files: Sequence[Path] = ()
) -> Prediction:
    """Predict the stop of every event in `file` by the stored model `name`; nothing is stored.

    Numbers are elevations of the stop in m, of the avalanche itself and not of a record with its
    error; that of a release (`release_sigma_m`) is in them. For events without a profile they are
    runout lengths, or H/L where that alone is known, and `coordinate` says so. A draw that leaves
    the profile counts as reaching its end. Raises `AvahazardError` where there is no such model, or
    it cannot predict these events; `RejectedRows` for rows of the file that cannot be taken.
    """
    stored, records = load_stored(database, name, effect_files)
    require_comparable(stored)
    new = _new_events(file, records)
    if not new.events:
        raise AvahazardError(f"{file} has no events.", "A row for each: event_id, path_id, …")
    of_all = [*notes_of_fit(stored)]
    on = partial(on_events, stored, records)
    model = on(new.events)
    stops = predict_stops(model, STOP_DRAWS, generator(0, "predict"))
    values, left = told(model.observations, stops.record, stops.elevation), stops.left
    sigma = stated_release_sigma(new.events, {p.path_id: p for p in records.paths})
    unsure = np.flatnonzero(sigma > 0.0)
    if len(unsure):
        values[unsure], left[unsure] = stops_over_releases(
            on,
            [new.events[i] for i in unsure],
            sigma[unsure],
            STOP_DRAWS,
            generator(0, "predict release"),
        )
    if stops.n_nonpositive:
        share = stops.n_nonpositive / stops.friction.size
        of_all.append(Note("friction_not_positive", share=share))
    notes = [*_of_largest(stored, new.events), *of_all]
    if model.observations.in_ratio:
        notes.append(Note("in_ratio"))
    elif np.any(model.observations.kind == LENGTH):
        notes.append(Note("in_lengths"))
    measured = tuple(e for e in new.events if _has_runout(e))
    scores = None
    if measured:
        scores = _scores(model if len(measured) == len(new.events) else on(measured))
    rows = (
        _row(e, v, left, (*_of_volume(stored, e.path_id, e.volume_m3), *of_all))
        for e, v, left in zip(new.events, values, left, strict=True)
    )
    return Prediction(Rows(rows), scores, tuple(notes))


def _new_events(file: Path, records: Records) -> Records:
    try:
        return read_records([file], known=records, need_runout=False)
    except RejectedRows as error:
        error.message = error.message.replace("imported", "predicted")
        error.hint = "Correct the rows above and predict again."
        raise


def _of_largest(stored: FittedModel, events: Sequence[Event]) -> list[Note]:
    """Notes on the largest volume of each path, which is farthest beyond the records."""
    largest: dict[str | None, float] = {}
    for event in events:
        if event.volume_m3 is not None:
            known = largest.get(event.path_id, 0.0)
            largest[event.path_id] = max(known, event.volume_m3)
    return [note for path, volume in largest.items() for note in _of_volume(stored, path, volume)]


def _of_volume(model: FittedModel, path_id: str | None, volume_m3: float | None) -> list[Note]:
    """Notes on a volume beyond the records, or with a friction that no avalanche has."""
    if volume_m3 is None or model.ignores_volume:
        return []
    of = () if path_id is None else (path_id,)
    return extrapolation(model, path_id, volume_m3).notes(*of)


def _has_runout(event: Event) -> bool:
    e = event
    found = (e.runout_x_m, e.runout_elevation_m, e.runout_length_m, e.h_over_l)
    return e.left_profile or any(value is not None for value in found)


def _row(
    event: Event, values: Floats, left: NDArray[np.bool_], notes: tuple[Note, ...]
) -> PredictedEvent:
    q05, q50, q95 = np.quantile(values, [0.05, 0.5, 0.95])
    return PredictedEvent(
        event_id=event.event_id,
        path_id=event.path_id,
        coordinate="elevation" if event.path_id else RATIO if event.in_ratio else "length",
        mean_m=float(np.mean(values)),
        sd_m=float(np.std(values, ddof=1)),
        q05_m=float(q05),
        q50_m=float(q50),
        q95_m=float(q95),
        p_left_profile=float(np.mean(left)),
        notes=notes,
    )


def _scores(model: FittedModel) -> PredictionScores:
    """Scores over new records; `elpd_loo` is their log predictive density."""
    rng = generator(0, "predict scores")
    expected = expected_records(model, RECORD_DRAWS, rng)
    pit = record_pit(expected, rng)
    budget = error_budget(model, generator(0, "error budget"))
    offsets = model.group_offsets(rng)
    given = [
        model.posterior.event_log_likelihood(
            model.draws[k], None if offsets is None else offsets[k]
        )
        for k in model.evenly(DENSITY_DRAWS)
    ]
    density = logsumexp(given, axis=0) - np.log(len(given))
    n = len(density)
    return PredictionScores(
        runout=runout_scores(expected, pit, budget.floor),
        speed=None,
        elpd_loo=float(np.sum(density)),
        elpd_loo_se=float(np.sqrt(n) * np.std(density, ddof=1)) if n > 1 else None,
        coordinate=coordinate_name(model.observations),
        runout_x=x_scores(expected, model.observations, budget.floor),
    )
