"""Models against the measurements: scores, held-out scores, where one fails, and their ladder."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.criticism.scoring.error_budget import (
    ErrorBudget,
    budget_by_event,
    budget_parts,
    error_budget,
    profile_part,
    with_explained,
)
from avahazard.criticism.scoring.expected import expected_records
from avahazard.criticism.scoring.held_out import (
    HeldOut,
    HeldOutPredictions,
    choose_groups,
    group_errors,
    held_out_predictions,
)
from avahazard.criticism.scoring.loo import leave_one_out
from avahazard.criticism.scoring.scores import (
    randomised_pit,
    record_pit,
    runout_scores,
    speed_scores,
    x_scores,
)
from avahazard.criticism.scoring.speed_misfit import (
    MatchedSpeeds,
    matched_speeds,
    measured_force,
    speed_misfit,
)
from avahazard.criticism.scoring.where_it_fails import event_axes, where_it_fails
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, PLACE, Observations
from avahazard.inference.prediction import ground_error
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.records.errors import AvahazardError
from avahazard.report.picture import require_picture
from avahazard.results.base import RATIO, Report, Rows, plain, silent
from avahazard.results.comparison import (
    Comparison,
    HeldOutScores,
    Ladder,
    Rung,
    Scores,
    SpeedScores,
    Standing,
)
from avahazard.store.records import load_records
from avahazard.store.results import (
    COMPARISON,
    StoredModel,
    latest_result,
    list_models,
    load_model,
    save_result,
)
from avahazard.store.session import reading, writing
from avahazard.workflow.next_step import StoredModels, next_step
from avahazard.workflow.stored import load_stored, notes_of, notes_of_fit, require_unchanged

RECORD_DRAWS = 1000
COORDINATES = {ELEVATION: "elevation", LEFT: "elevation", PLACE: "x", LENGTH: "length"}


def compare(
    database: str,
    name: str,
    *,
    effect_files: Sequence[Path] = (),
    plot: Path | None = None,
    report: Report = silent,
) -> Comparison:
    """Compare the stored model `name` with its measurements, and store the comparison.

    `plot` is a picture of where it fails. Raises `AvahazardError` where there is no such model, its
    records have changed, or its method has no predictive distribution of the friction, or `plot` is
    not the name of a picture.
    """
    require_picture(plot)
    stored, _ = load_stored(database, name, effect_files)
    require_comparable(stored)
    require_unchanged(stored)
    found = comparison(name, stored, lambda share: report(f"Comparing {name}", share, 1.0))
    found = replace(found, notes=notes_of_fit(stored))
    with writing(database) as session:
        parent = load_model(session, name).parent
        if parent is not None:
            before = stored_comparison(latest_result(session, COMPARISON, parent))
            of_parent = load_model(session, parent).effects
            added = [key for key in stored.specification.effects if key not in of_parent]
            found = with_explained(found, before, added)
        save_result(session, COMPARISON, name, plain(found, keyed=True))
    if plot is not None:
        from avahazard.report.score_pictures import draw_comparison  # noqa: PLC0415 (slow)

        draw_comparison(plot, found)
    return replace(found, next=next_step(database, name))


def stored_comparison(document: dict[str, Any] | None) -> Comparison | None:
    """The comparison of a stored document; None where there is none."""
    return None if document is None else Comparison.from_dict(document)


def require_comparable(model: FittedModel) -> None:
    """Raise `AvahazardError` for a model whose scatter is not on friction."""
    if model.sigma_m is not None:
        raise AvahazardError(
            f"The model {model.name} was calibrated by method {model.method}, whose scatter is in "
            "metres and holds all errors at once: it cannot be set against them.",
            "Calibrate with --method marginal (or gibbs) to compare.",
        )


def comparison(
    name: str, model: FittedModel, progress: Callable[[float], None] = lambda _share: None
) -> Comparison:
    """A model against the records that it was fitted to; nothing is stored."""
    observations = model.observations
    # The budget takes most memory, and leaves little: it comes before the draws that stay.
    budget = error_budget(model, generator(0, "error budget"))
    rng = generator(0, "compare")
    expected = expected_records(model, RECORD_DRAWS, rng)
    pit = record_pit(expected, rng)
    of_profile = ground_error(model)
    progress(0.09)
    speeds = matched_speeds(model, rng)
    progress(0.15)
    loo = leave_one_out(model)
    progress(0.24)
    held = choose_groups(observations)
    others = held_out_predictions(model, held.fits, lambda share: progress(0.24 + 0.71 * share))
    axes = event_axes(observations, np.median(expected.x, axis=1))
    return Comparison(
        model=name,
        coordinate=coordinate_name(observations),
        scores=Scores(
            runout=runout_scores(expected, pit, budget.floor),
            speed=_speed_scores(speeds),
            elpd_loo=loo.elpd,
            elpd_loo_se=loo.se,
            pareto_k_bad=loo.n_bad,
            pareto_k_refitted=loo.n_refitted,
            runout_x=x_scores(expected, observations, budget.floor),
        ),
        held_out=_held_out_scores(held, others, observations, budget),
        where_it_fails=where_it_fails(axes, expected.error, pit, observations.columns.path_index),
        speed_misfit=None if speeds is None else speed_misfit(observations, speeds),
        measured_force=measured_force(observations) if observations.speeds else None,
        budget=budget_parts(expected.error, budget),
        budget_by_event=budget_by_event(observations, expected.error, budget, of_profile),
        profile_m=profile_part(observations, of_profile),
    )


def coordinate_name(observations: Observations) -> str:
    """The coordinate of the records: elevation, x, length, h_over_l, or mixed."""
    if observations.in_ratio:
        return RATIO
    names = {
        COORDINATES[int(kind)] for kind in np.unique(observations.kind[observations.kind != LEFT])
    }
    return names.pop() if len(names) == 1 else ("mixed" if names else "elevation")


def _held_out_scores(
    held: HeldOut, others: HeldOutPredictions, observations: Observations, budget: ErrorBudget
) -> HeldOutScores:
    rng = generator(0, "held out scores")
    pit = record_pit(others.records, rng)
    n = len(others.log_density)
    return HeldOutScores(
        by=held.by,
        runout=runout_scores(others.records, pit, budget.floor),
        speed=_speed_scores(others.speeds),
        elpd_loo=float(np.sum(others.log_density)),
        elpd_loo_se=float(np.sqrt(n) * np.std(others.log_density, ddof=1)) if n > 1 else None,
        runout_x=x_scores(others.records, observations, budget.floor),
        groups=group_errors(held, others, observations),
        n_fits=len(np.unique(held.fits)),
    )


def _speed_scores(speeds: MatchedSpeeds | None) -> SpeedScores | None:
    if speeds is None:
        return None
    pit = randomised_pit(speeds.draws, speeds.observed, generator(0, "speed scores"))
    return speed_scores(speeds.draws, speeds.observed, speeds.sigma, pit)


SCORES = (
    "rmse_m",
    "crps_m",
    "held_out_crps_m",
    "elpd_loo",
    "elpd_loo_se",
    "coverage_90",
    "speed_rmse_m_s",
    "noise_floor_m",
    "noise_floor_crps_m",
    "held_out_crps_x_m",
)


def ladder(database: str, *, plot: Path | None = None, report: Report = silent) -> Ladder:
    """Rank all models by their error; those never compared are compared, and that is stored.

    `plot` is a picture of the held-out error from model to model, and of their error budgets.
    Raises `AvahazardError` where the database is missing or has no model, or `plot` is no picture.
    """
    require_picture(plot)
    with reading(database) as session:
        models = list_models(session)
        records = load_records(session)
        told = {model.name: notes_of(model, records) for model in models}
        known = {
            model.name: stored_comparison(latest_result(session, COMPARISON, model.name))
            for model in models
        }
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
        from avahazard.report.score_pictures import draw_ladder  # noqa: PLC0415 (slow)

        draw_ladder(plot, rows, {k: v for k, v in known.items() if v is not None})
    with reading(database) as session:
        stored = StoredModels(session)
        best = stored.best()
        step = stored.step(best)
    # Of the others' notes, which stand in their rows, nobody has to act on any.
    lacking = [n for found in told.values() for n in found if n.key == "not_comparable"]
    return Ladder(rows, tuple(dict.fromkeys((*told[best], *lacking))), step)


def ladder_rows(
    models: Sequence[StoredModel],
    comparisons: Mapping[str, Comparison | None],
    notes: Mapping[str, tuple[Note, ...]],
) -> Rows[Rung]:
    """A rung for each model, with its notes; its scores are None where there is no comparison."""
    effects = {model.name: model.effects for model in models}
    rows = []
    for model in models:
        found = comparisons[model.name]
        before = effects.get(model.parent or "", ())
        scores = {} if found is None else standing(found).to_dict()
        rows.append(
            Rung(
                model=model.name,
                parent=model.parent,
                added=tuple(key for key in effects[model.name] if key not in before),
                coordinate=None if found is None else found.coordinate,
                notes=notes.get(model.name, ()),
                **{key: scores.get(key) for key in SCORES},
            )
        )
    return Rows(rows)


def standing(comparison: Comparison) -> Standing:
    """The scores of a comparison by which models are ranked."""
    scores, held_out = comparison.scores, comparison.held_out
    runout, speed = scores.runout, scores.speed
    return Standing(
        rmse_m=runout.rmse_m,
        crps_m=runout.crps_m,
        held_out_rmse_m=held_out.runout.rmse_m,
        held_out_crps_m=held_out.runout.crps_m,
        held_out_elpd=held_out.elpd_loo,
        elpd_loo=scores.elpd_loo,
        elpd_loo_se=scores.elpd_loo_se,
        coverage_90=runout.coverage_90,
        speed_rmse_m_s=None if speed is None else speed.rmse_m_s,
        noise_floor_m=runout.noise_floor_m,
        noise_floor_crps_m=runout.noise_floor_crps_m,
        held_out_crps_x_m=None if held_out.runout_x is None else held_out.runout_x.crps_m,
    )
