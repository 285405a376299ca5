"""Every model and its error, oldest first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from avahazard.notes import Note
from avahazard.records.errors import AvahazardError
from avahazard.report.picture import require_picture
from avahazard.results.base import Report, Rows, silent
from avahazard.results.comparison import Comparison
from avahazard.results.ladder import Ladder, Rung, Standing
from avahazard.store.models import StoredModel, list_models
from avahazard.store.records import load_records
from avahazard.store.results import COMPARISON, latest_result
from avahazard.store.session import reading
from avahazard.workflow.compare import compare, stored_comparison
from avahazard.workflow.stored.notes import notes_of
from avahazard.workflow.stored.own_effects import effects_of

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


def ladder(
    database: str,
    *,
    plot: Path | None = None,
    report: Report = silent,
) -> Ladder:
    """Rank all models by their error; those never compared are compared, and that is stored.

    `plot` is a picture of the held-out error from model to model, and of their error budgets.

    Raises:
        AvahazardError: the database is missing or has no model, or `plot` is no picture.
    """
    require_picture(plot)
    with reading(database) as session:
        models = list_models(session)
        records = load_records(session)
        told = {model.name: notes_of(session, model.name, records) for model in models}
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
    return Ladder(rows, tuple(note for notes in told.values() for note in notes))


def ladder_rows(
    models: Sequence[StoredModel],
    comparisons: Mapping[str, Comparison | None],
    notes: Mapping[str, tuple[Note, ...]],
) -> Rows[Rung]:
    """A rung for each model, with its notes; its scores are None where there is no comparison."""
    effects = {model.name: effects_of(model) for model in models}
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
