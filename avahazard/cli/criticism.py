"""Commands that set a model against measurements: compare, diagnose, ladder, predict."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from rich.console import Console

from avahazard.cli.options import EffectFiles, StoredModel, answers, argument, picture
from avahazard.cli.output import settings, show
from avahazard.report import model_tables
from avahazard.report.sentences import error_words, failure_words, verdict_words
from avahazard.results.base import plain
from avahazard.results.comparison import Comparison, Prediction
from avahazard.results.diagnosis import Candidate, Diagnosis
from avahazard.workflow.requests import DiagnoseRequest


def show_comparison(console: Console, found: Comparison) -> None:
    """Print scores, the budget of errors, and where the model fails."""
    scores = found.scores
    show(console, model_tables.scores_table(found.coordinate, model_tables.compared_parts(found)))
    for words in error_words(found):
        console.print(words)
    if scores.elpd_loo is not None:
        se = "" if scores.elpd_loo_se is None else f" ± {scores.elpd_loo_se:.1f}"
        console.print(f"elpd, each record left out in turn: {scores.elpd_loo:.1f}{se} nats.")
    for made in (model_tables.budget_table, model_tables.misfit_table, model_tables.failures_table):
        show(console, made(found))
    console.print(failure_words(found))


def _notes(found: Comparison) -> Iterator[str]:
    yield from found.notes
    unsure = found.scores.pareto_k_bad - found.scores.pareto_k_refitted
    if unsure > 0:
        weigh = "record weighs" if unsure == 1 else "records weigh"
        yield f"{unsure} {weigh} so much that the left-out density is rough (Pareto k > 0.7)."


@answers("compare.compare", show_comparison, notes=_notes)
def compare(
    name: StoredModel,
    plot: Annotated[Path | None, picture("Draw where it fails")] = None,
    effect_files: EffectFiles = None,
) -> None:
    """Set a model against the measurements: its scores, and where it fails.

    \b
    Examples:
      avahazard compare first
      avahazard compare first --plot where.png
    """


ALONE = 0.05
CANDIDATES_SHOWN = 8


def show_diagnosis(console: Console, found: Diagnosis) -> None:
    """Print the verdict, the candidates, and what else was found."""
    console.print(verdict_words(found, found.model), soft_wrap=True)
    if found.declared is not None:
        words = ", ".join(found.declared.effects)
        console.print(f"Declared beforehand ({found.declared.at}), tested first: {words}.")
    candidates = model_tables.candidates_table(found)
    show(console, replace(candidates, shown=max(candidates.shown or 0, CANDIDATES_SHOWN)))
    best = found.candidates[0] if found.candidates else None
    if found.missing and best is not None and best.effect in found.missing:
        console.print(best.physics, soft_wrap=True)
    show(console, model_tables.shape_table(found))
    show(console, model_tables.laws_table(found))
    if found.effect_file is not None:
        console.print(f"Written: {found.effect_file}", soft_wrap=True)
    elif found.lawful is not None:
        words = f"avahazard diagnose {found.model} --write-effect FILE"
        console.print(f"The first as an effect file: {words}", soft_wrap=True)
    if found.verdict == "adequate" and best is not None:
        _nearest(console, best, len(found.candidates))
    _findings(console, found)
    # Where an effect is named it is added first; what parts it from others comes after.
    if found.verdict != "missing-effect" or settings().verbose:
        show(console, model_tables.measure_table(found))


def _nearest(console: Console, best: Candidate, n_tried: int) -> None:
    """A candidate that would count had it been the only question."""
    if best.p_value_alone < ALONE:
        alone = "< 0.001" if best.p_value_alone < 0.001 else f"= {best.p_value_alone:.3f}"
        console.print(
            f"{best.effect} comes nearest: p {alone} by itself, "
            f"{best.p_value:.2f} as the best of {n_tried}. The first counts only where it was "
            "declared beforehand (--expect).",
            soft_wrap=True,
        )


def _findings(console: Console, found: Diagnosis) -> None:
    """What else was found, beside the candidates, as what the measured force says of them."""
    for c in found.candidates[:CANDIDATES_SHOWN]:
        if c.force_witness is not None:
            value, se = c.force_witness.value, c.force_witness.se
            fitted = ", ".join(f"{k} {v:.3g}" for k, v in c.parameters.items())
            console.print(
                f"The measured force has {value:.2g} ± {se:.2g} of {c.effect} (fitted: {fitted}).",
                soft_wrap=True,
            )
    if found.impossible_stops:
        n = len(found.impossible_stops)
        console.print(
            f"{n} recorded {'stop' if n == 1 else 'stops'} on ground too steep for a block to stop "
            f"there: {', '.join(found.impossible_stops[:6])}{', …' if n > 6 else ''}.",
            soft_wrap=True,
        )
    if found.heavy_tails:
        console.print(
            "Friction scatters with heavy tails: Student's t was used. Look at wrong records: "
            f"{', '.join(found.suspect_events[:6]) or 'none stands out'}.",
            soft_wrap=True,
        )
    for effect, loss in found.still_needed.items():
        need = "is still needed" if loss > 0 else "is no longer needed"
        console.print(f"{effect} {need} (evidence {loss:+.1f} nats).")


@answers("diagnose.diagnose_model", show_diagnosis)
def diagnose(name: StoredModel, *, request: DiagnoseRequest) -> None:
    """Ask which effect a model lacks, if any; what to measure next.

    \b
    Examples:
      avahazard diagnose first
      avahazard diagnose first --expect snow-type
      avahazard diagnose first --plot candidates.png
      avahazard diagnose first --write-effect law.py
    """


EXTRA = {"noise_floor_m", "noise_floor_crps_m"}
"""Of the steps of the ladder, what the table alone shows."""


@answers(
    "compare.ladder",
    lambda console, found: show(console, model_tables.ladder_table(found.rows)),
    document=lambda found: [
        {key: value for key, value in row.items() if key not in EXTRA} for row in plain(found.rows)
    ],
)
def ladder(
    plot: Annotated[Path | None, picture("Draw the held-out error and the error budgets")] = None,
) -> None:
    """List every model and its error, oldest first.

    \b
    Examples:
      avahazard ladder
      avahazard ladder --plot ladder.png
    """


def show_prediction(console: Console, found: Prediction) -> None:
    """Print the events with their predicted runouts, and the scores where runouts are given."""
    show(console, model_tables.predicted_table(found.events))
    if found.scores is not None:
        scores = [("these events", found.scores)]
        show(console, model_tables.scores_table(found.scores.coordinate, scores))


@answers(
    "compare.predict",
    show_prediction,
    # Elevations, unless `coordinate` of a row says otherwise (docs/results.md).
    document=lambda found: (
        found.events if found.scores is None else {"events": found.events, "scores": found.scores}
    ),
)
def predict(
    name: StoredModel,
    file: Annotated[Path, argument("Events.", "EVENTS.csv")],
    effect_files: EffectFiles = None,
) -> None:
    """Predict the runout of each event of a file; its own runout only serves for scores.

    \b
    Example:
      avahazard predict first new-events.csv
    """
