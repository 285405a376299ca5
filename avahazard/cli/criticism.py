"""Commands that set a model against measurements: compare, diagnose, ladder, predict."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import EffectFiles, StoredModel, picture
from avahazard.cli.output import emit, settings, show, show_next, warn
from avahazard.progress import show_progress
from avahazard.records.plain import plain
from avahazard.report.language import TERMINAL
from avahazard.report.model_tables import (
    budget_table,
    candidates_table,
    compared_parts,
    failures_table,
    ladder_table,
    laws_table,
    measure_table,
    misfit_table,
    predicted_table,
    scores_table,
    shape_table,
)
from avahazard.report.sentences import error_words, failure_words, verdict_words
from avahazard.results.diagnosis import Candidate, Diagnosis
from avahazard.workflow.requests import DiagnoseRequest


def compare(
    context: typer.Context,
    name: StoredModel,
    plot: Annotated[Path | None, picture("Draw where it fails")] = None,
    effect_file: EffectFiles = None,
) -> None:
    """Set a model against the measurements: its scores, and where it fails.

    \b
    Examples:
      avahazard compare first
      avahazard compare first --plot where.png
    """
    from avahazard.workflow.compare import compare as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(
            settings(context).database,
            name,
            effect_files=effect_file or (),
            plot=plot,
            report=report,
        )
    scores = found.scores

    def render(console: Console) -> None:
        show(console, scores_table(found.coordinate, compared_parts(found, TERMINAL), TERMINAL))
        for words in error_words(found, TERMINAL):
            console.print(words)
        if scores.elpd_loo is not None:
            se = "" if scores.elpd_loo_se is None else f" ± {scores.elpd_loo_se:.1f}"
            console.print(f"elpd, each record left out in turn: {scores.elpd_loo:.1f}{se} nats.")
        show(console, budget_table(found, TERMINAL))
        show(console, misfit_table(found, TERMINAL))
        show(console, failures_table(found, TERMINAL), verbose=settings(context).verbose)
        console.print(failure_words(found, TERMINAL))

    emit(context, found, render)
    warn(*found.notes)
    unsure = scores.pareto_k_bad - scores.pareto_k_refitted
    if unsure > 0:
        weigh = "record weighs" if unsure == 1 else "records weigh"
        warn(f"{unsure} {weigh} so much that the left-out density is rough (Pareto k > 0.7).")


ALONE = 0.05
CANDIDATES_SHOWN = 8


def diagnose(
    context: typer.Context,
    name: StoredModel,
    *,
    request: DiagnoseRequest,
) -> None:
    """Ask which effect a model lacks, if any; what to measure next.

    \b
    Examples:
      avahazard diagnose first
      avahazard diagnose first --expect snow-type
      avahazard diagnose first --plot candidates.png
      avahazard diagnose first --write-effect law.py
    """
    from avahazard.workflow.diagnose import diagnose_model  # noqa: PLC0415

    with show_progress() as report:
        found = diagnose_model(settings(context).database, name, request, report)

    def render(console: Console) -> None:
        console.print(verdict_words(found, found.model, TERMINAL), soft_wrap=True)
        if found.declared is not None:
            words = ", ".join(found.declared.effects)
            console.print(f"Declared beforehand ({found.declared.at}), tested first: {words}.")
        candidates = candidates_table(found, TERMINAL)
        shown = max(candidates.shown or 0, CANDIDATES_SHOWN)
        show(console, replace(candidates, shown=shown), verbose=settings(context).verbose)
        best = found.candidates[0] if found.candidates else None
        if found.missing and best is not None and best.effect in found.missing:
            console.print(best.physics, soft_wrap=True)
        show(console, shape_table(found, TERMINAL))
        show(console, laws_table(found, TERMINAL))
        if found.effect_file is not None:
            console.print(f"Written: {found.effect_file}", soft_wrap=True)
        elif found.lawful is not None:
            words = f"avahazard diagnose {found.model} --write-effect FILE"
            console.print(f"The first as an effect file: {words}", soft_wrap=True)
        if found.verdict == "adequate" and best is not None:
            _nearest(console, best, len(found.candidates))
        _findings(console, found)
        # Where an effect is named it is added first; what parts it from others comes after.
        if found.verdict != "missing-effect" or settings(context).verbose:
            show(console, measure_table(found, TERMINAL))

    emit(context, found, render)
    warn(*found.notes)


def _nearest(console: Console, best: Candidate, n_tried: int) -> None:
    """A candidate that would count had it been the only question."""
    if best.p_value_alone < ALONE:
        console.print(
            f"{best.effect} comes nearest: p = {best.p_value_alone:.3f} by itself, "
            f"{best.p_value:.2f} as the best of {n_tried}. The first counts only where it was "
            "declared beforehand (--expect).",
            soft_wrap=True,
        )


def _witnesses(console: Console, found: Diagnosis) -> None:
    """What the measured force says of the candidates on the motion."""
    for c in found.candidates[:CANDIDATES_SHOWN]:
        if c.force_witness is not None:
            value, se = c.force_witness.value, c.force_witness.se
            fitted = ", ".join(f"{k} {v:.3g}" for k, v in c.parameters.items())
            console.print(
                f"The measured force has {value:.2g} ± {se:.2g} of {c.effect} (fitted: {fitted}).",
                soft_wrap=True,
            )


def _findings(console: Console, found: Diagnosis) -> None:
    """What else was found, beside the candidates."""
    _witnesses(console, found)
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


def ladder(
    context: typer.Context,
    plot: Annotated[Path | None, picture("Draw the held-out error and the error budgets")] = None,
) -> None:
    """List every model and its error, oldest first.

    \b
    Examples:
      avahazard ladder
      avahazard ladder --plot ladder.png
    """
    from avahazard.workflow.compare import ladder as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(settings(context).database, plot=plot, report=report)
    extra = ("noise_floor_m", "noise_floor_crps_m")
    document = [{k: v for k, v in row.items() if k not in extra} for row in plain(found.rows)]

    def render(console: Console) -> None:
        show(console, ladder_table(found.rows, TERMINAL))
        show_next(context, console, found.next)

    emit(context, document, render)
    warn(*found.notes)


def predict(
    context: typer.Context,
    name: StoredModel,
    events: Annotated[
        Path, typer.Argument(metavar="EVENTS.csv", help="Events.", show_default=False)
    ],
    effect_file: EffectFiles = None,
) -> None:
    """Predict the runout of each event of a file; its own runout only serves for scores.

    \b
    Example:
      avahazard predict first new-events.csv
    """
    from avahazard.workflow.predict import predict as run  # noqa: PLC0415

    found = run(settings(context).database, name, events, effect_files=effect_file or ())
    rows, scores = found.events, found.scores
    # Elevations, unless `coordinate` of a row says otherwise (docs/results.md).
    document = rows if scores is None else {"events": rows, "scores": scores}

    def render(console: Console) -> None:
        show(console, predicted_table(rows, TERMINAL))
        if scores is not None:
            show(console, scores_table(scores.coordinate, [(name, scores)], TERMINAL))

    emit(context, document, render)
    warn(*found.notes)
