"""Models against the measurements: scores, where one fails, their ladder, and new events."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import logsumexp

from avahazard.arrays import Bools, Floats
from avahazard.criticism.scoring import error_budget as budgets
from avahazard.criticism.scoring import scores as scoring
from avahazard.criticism.scoring import speed_misfit as speeds_of
from avahazard.criticism.scoring.change import standing
from avahazard.criticism.scoring.held_out import choose_groups, group_errors, held_out_predictions
from avahazard.criticism.scoring.loo import leave_one_out
from avahazard.criticism.scoring.where_it_fails import event_axes, where_it_fails
from avahazard.effects.columns import build_columns
from avahazard.effects.covariate import unknown_values
from avahazard.effects.effect import Effect
from avahazard.inference import prediction
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, PLACE, Observations
from avahazard.inference.model.release_errors import stated_release_sigma
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.records.collection import Event, Records, only_paths
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.records.reading import read_records
from avahazard.report.picture import require_picture
from avahazard.results import comparison as results
from avahazard.results.base import RATIO, Report, Rows, plain, silent
from avahazard.store import results as store
from avahazard.store.records import load_records
from avahazard.store.session import reading, writing
from avahazard.workflow.next_step import StoredModels, latest_comparison, next_step
from avahazard.workflow.stored import (
    load_stored,
    notes_of,
    notes_of_fit,
    on_events,
    require_friction_scatter,
    require_unchanged,
)

RECORD_DRAWS = 1000
COORDINATES = {ELEVATION: "elevation", LEFT: "elevation", PLACE: "x", LENGTH: "length"}


def compare(
    database: str,
    name: str,
    *,
    effect_files: Sequence[Path] = (),
    plot: Path | None = None,
    report: Report = silent,
) -> results.Comparison:
    """Compare the stored model `name` with its measurements, and store the comparison.

    `plot` is a picture of where it fails. Raises `AvahazardError` where there is no such model, its
    records have changed, its method does not predict friction, or `plot` is no picture's name.
    """
    require_picture(plot)
    stored, _ = load_stored(database, name, effect_files)
    require_friction_scatter(stored)
    require_unchanged(stored)
    found = comparison(name, stored, partial(report, f"Comparing {name}"))
    found = replace(found, notes=(*notes_of_fit(stored), *_on_held_out(found)))
    with writing(database) as session:
        if parent := stored.calibration.parent:
            before, known = latest_comparison(session, parent), store.load_model(session, parent)
            added = [key for key in stored.specification.effects if key not in known.effects]
            found = budgets.with_explained(found, before, added)
            # What `add` found of the parent by the folds of its child stands.
            if last := latest_comparison(session, name):
                error = last.held_out.parent_crps_m
                found = replace(found, held_out=replace(found.held_out, parent_crps_m=error))
        store.save_result(session, store.COMPARISON, name, plain(found, keyed=True))
    if plot is not None:
        found.plot(plot)
    return replace(found, next=next_step(database, name))


def comparison(
    name: str,
    model: FittedModel,
    progress: Callable[[float], None] = lambda _share: None,
    effects: Sequence[Effect] | None = None,
) -> results.Comparison:
    """A model against the records that it was fitted to; nothing is stored.

    Held-out groups are those of a model with these `effects`, by default its own.
    """
    observations = model.observations
    # The budget takes most memory, and leaves little: it comes before the draws that stay.
    budget = budgets.error_budget(model, generator(0, "error budget"))
    rng = generator(0, "compare")
    expected = scoring.expected_records(model, RECORD_DRAWS, rng)
    pit = scoring.record_pit(expected, rng)
    of_profile = prediction.ground_error(model)
    progress(0.09)
    speeds = speeds_of.matched_speeds(model, rng)
    progress(0.15)
    loo = leave_one_out(model)
    progress(0.24)
    held = choose_groups(observations, model.posterior.effects if effects is None else effects)
    others = held_out_predictions(model, held.fits, lambda share: progress(0.24 + 0.71 * share))
    held_pit = scoring.record_pit(others.records, generator(0, "held out scores"))
    axes = event_axes(observations, np.median(expected.x, axis=1))
    return results.Comparison(
        model=name,
        coordinate=coordinate_name(observations),
        scores=results.Scores(
            **_scored(expected, pit, loo.by_event, observations, budget, speeds),
            pareto_k_bad=loo.n_bad,
            pareto_k_refitted=loo.n_refitted,
        ),
        held_out=results.HeldOutScores(
            by=held.by,
            **_scored(
                others.records, held_pit, others.log_density, observations, budget, others.speeds
            ),
            groups=group_errors(held, others, observations),
            n_fits=len(np.unique(held.fits)),
        ),
        where_it_fails=where_it_fails(axes, expected.error, pit, observations.columns.path_index),
        speed_misfit=None if speeds is None else speeds_of.speed_misfit(observations, speeds),
        measured_force=speeds_of.measured_force(observations) if observations.speeds else None,
        budget=budgets.budget_parts(expected.error, budget),
        budget_by_event=budgets.budget_by_event(observations, expected.error, budget, of_profile),
        profile_m=budgets.profile_part(observations, of_profile),
    )


def coordinate_name(observations: Observations) -> str:
    """The coordinate of the records: elevation, x, length, h_over_l, or mixed."""
    if observations.in_ratio:
        return RATIO
    names = {COORDINATES[int(kind)] for kind in observations.kind if kind != LEFT} or {"elevation"}
    return names.pop() if len(names) == 1 else "mixed"


def _scored(
    records: scoring.ExpectedRecords,
    pit: Floats,
    log_density: Floats,
    observations: Observations,
    budget: budgets.ErrorBudget,
    speeds: speeds_of.MatchedSpeeds | None,
) -> dict[str, Any]:
    """The scores that all comparisons have; a single record's density has no standard error."""
    n = len(log_density)
    return {
        "runout": scoring.runout_scores(records, pit, budget.floor),
        "runout_x": scoring.x_scores(records, observations, budget.floor),
        "speed": scoring.speed_scores(speeds),
        "elpd_loo": float(np.sum(log_density)),
        "elpd_loo_se": float(np.sqrt(n) * np.std(log_density, ddof=1)) if n > 1 else None,
    }


SCORES = {f.name for f in fields(results.LadderEntry)} & {f.name for f in fields(results.Standing)}
"""The scores of an entry of the ladder."""


def ladder(database: str, *, plot: Path | None = None, report: Report = silent) -> results.Ladder:
    """Rank all models by their error; those never compared are compared, and that is stored.

    `plot` is a picture of the held-out error from model to model, and of their error budgets.
    Raises `AvahazardError` where the database is missing or has no model, or `plot` is no picture.
    """
    require_picture(plot)
    with reading(database) as session:
        models = store.list_models(session)
        records = load_records(session)
        told = {model.name: notes_of(model, records) for model in models}
        known = {model.name: latest_comparison(session, model.name) for model in models}
    if not models:
        raise AvahazardError(
            "There is no model yet.", "Make one: avahazard calibrate NAME, then avahazard add."
        )
    for model in models:
        if known[model.name] is None:
            try:
                known[model.name] = compare(database, model.name, report=report)
            except AvahazardError as error:
                told[model.name] += (Note("not_comparable", model=model.name, why=error.message),)
    rows = ladder_rows(models, known, told)
    if plot is not None:
        from avahazard.report.figure_pictures import draw_ladder  # noqa: PLC0415 (slow)

        drawn = {name: found for name, found in known.items() if found}
        draw_ladder(plot, results.Ladder(rows), drawn)
    with reading(database) as session:
        stored = StoredModels(session)
        best = stored.best()
        step = stored.step(best)
    # Of the others' notes, which stand in their rows, nobody has to act on any.
    lacking = [n for found in told.values() for n in found if n.key == "not_comparable"]
    return results.Ladder(rows, tuple(dict.fromkeys((*told[best], *lacking))), step)


def ladder_rows(
    models: Sequence[store.StoredModel],
    comparisons: Mapping[str, results.Comparison | None],
    notes: Mapping[str, tuple[Note, ...]],
) -> Rows[results.LadderEntry]:
    """An entry for each model, with its notes; its scores are None where there is no comparison."""
    effects = {model.name: model.effects for model in models}
    rows = []
    for model in models:
        found = comparisons.get(model.name)
        before = effects.get(model.parent or "", ())
        scores = {} if found is None else standing(found).to_dict()
        rows.append(
            results.LadderEntry(
                model=model.name,
                parent=model.parent,
                added=tuple(key for key in model.effects if key not in before),
                coordinate=None if found is None else found.coordinate,
                notes=(*notes.get(model.name, ()), *_on_held_out(found)),
                **{key: scores.get(key) for key in SCORES},
            )
        )
    return Rows(rows)


def _on_held_out(found: results.Comparison | None) -> list[Note]:
    """That held-out groups differ from those of the parent."""
    if found is None or (error := found.held_out.parent_crps_m) is None:
        return []
    return [Note("held_out_by_event", model=found.model, crps=error)]


STOP_DRAWS = 2000
DENSITY_DRAWS = 500


def predict(
    database: str, name: str, file: Path, *, effect_files: Sequence[Path] = ()
) -> results.Prediction:
    """Predict the stop of every event in `file` by the stored model `name`; nothing is stored.

    Numbers are elevations (m) of the stop itself, not of a record with its error; the error of a
    release (`release_sigma_m`) is in them. For events without a profile they are runout lengths, or
    H/L where that alone is known (`coordinate`). A draw beyond the profile counts as its end.
    Raises `AvahazardError` where there is no such model, or it cannot predict these events;
    `RejectedRows` for rows of the file that cannot be taken.
    """
    stored, records = load_stored(database, name, effect_files)
    require_friction_scatter(stored)
    events = _new_events(file, records).events
    if not events:
        raise AvahazardError(f"{file} has no events.", "A row for each: event_id, path_id, …")
    of_all = [*notes_of_fit(stored)]
    known = {e.event_id: e for e in (*only_paths(records, stored.paths).events, *events)}
    paths = {p.path_id: p for p in records.paths}
    among = build_columns(list(known.values()), paths, np.full(len(known), np.nan))
    on = partial(on_events, stored, records, among=among)
    model = on(events)
    stops = prediction.predict_stops(model, STOP_DRAWS, generator(0, "predict"))
    values = prediction.told(model.observations, stops.record, stops.elevation)
    left = stops.left
    sigma = stated_release_sigma(events, paths)
    unsure = np.flatnonzero(sigma > 0.0)
    if len(unsure):
        some, rng = [events[i] for i in unsure], generator(0, "predict release")
        released = prediction.stops_over_releases(on, some, sigma[unsure], STOP_DRAWS, rng)
        values[unsure], left[unsure] = released
    for effect in stored.definitions:
        if effect.column is not None and not effect.uses_volume:
            of_all += unknown_values(effect.column, stored.facts[effect.key], model.columns)
    share = float(np.mean(stops.friction <= 0.0))
    if share:
        of_all.append(Note("friction_not_positive", share=share))
    rows = Rows(
        _row(e, v, left, (*_of_volume(stored, e), *of_all))
        for e, v, left in zip(events, values, left, strict=True)
    )
    notes = dict.fromkeys(note for row in rows for note in row.notes)
    if model.observations.in_ratio:
        notes[Note("in_ratio")] = None
    elif np.any(model.observations.kind == LENGTH):
        notes[Note("in_lengths")] = None
    measured = tuple(e for e in events if _has_runout(e))
    scores = None
    if measured:
        scores = _scores(model if len(measured) == len(events) else on(measured))
    return results.Prediction(rows, scores, tuple(notes))


def _new_events(file: Path, records: Records) -> Records:
    try:
        return read_records([file], known=records, need_runout=False)
    except RejectedRows as error:
        error.message = error.message.replace("imported", "predicted")
        error.hint = "Correct the rows above and predict again."
        raise


def _of_volume(model: FittedModel, event: Event) -> list[Note]:
    """Notes on a volume beyond the records, or with a friction that no avalanche has."""
    if event.volume_m3 is None or model.ignores_volume:
        return []
    of = () if event.path_id is None else (event.path_id,)
    return prediction.extrapolation(model, event.path_id, event.volume_m3, *of)


def _has_runout(event: Event) -> bool:
    found = (event.runout_x_m, event.runout_elevation_m, event.runout_length_m, event.h_over_l)
    return event.left_profile or any(value is not None for value in found)


def _row(
    event: Event, values: Floats, left: Bools, notes: tuple[Note, ...]
) -> results.PredictedEvent:
    q05, q50, q95 = np.quantile(values, [0.05, 0.5, 0.95])
    return results.PredictedEvent(
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


def _scores(model: FittedModel) -> results.PredictionScores:
    """Scores over new records; `elpd_loo` is their log predictive density."""
    rng = generator(0, "predict scores")
    expected = scoring.expected_records(model, RECORD_DRAWS, rng)
    pit = scoring.record_pit(expected, rng)
    budget = budgets.error_budget(model, generator(0, "error budget"))
    offsets = model.group_offsets(rng)
    given = [
        model.posterior.event_log_likelihood(
            model.draws[k], None if offsets is None else offsets[k]
        )
        for k in model.thinned(DENSITY_DRAWS)
    ]
    log_density = logsumexp(given, axis=0) - np.log(len(given))
    return results.PredictionScores(
        **_scored(expected, pit, log_density, model.observations, budget, None),
        coordinate=coordinate_name(model.observations),
    )
