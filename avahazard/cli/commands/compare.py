"""`avahazard compare`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.comparison_table import (
    budget_table,
    crps_words,
    error_words,
    failures,
    profile_words,
    show_scores,
    unit_words,
)
from avahazard.cli.options import EffectFiles, StoredModel, picture
from avahazard.cli.output import emit, table, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings
from avahazard.results.amounts import bare


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
    scores, held = found.scores, found.held_out

    def render(console: Console) -> None:
        whole = "paths" if held.by == "path" else "fifths of the events"
        parts = ((f"{whole} held out", held), ("calibrated on", scores))
        columns, cells = show_scores(found.coordinate, *parts)
        console.print(table(f"{name} against the records", columns, cells))
        console.print(
            f"The error of {name}, as add and ladder give it: CRPS where {whole} were held out, "
            f"{bare(held.runout.crps_m, found.coordinate)} {unit_words(found.coordinate)}."
        )
        if held.n_fits is not None and held.n_fits < len(held.groups):
            console.print(f"{len(held.groups)} {whole} were held out in {held.n_fits} parts.")
        console.print(crps_words(found.coordinate))
        console.print(f"bias: predicted mean less recorded. {error_words(found)}")
        console.print(
            f"Log predictive density, each record left out in turn (higher is better): "
            f"{scores.elpd_loo:.1f}"
            + ("." if scores.elpd_loo_se is None else f" ± {scores.elpd_loo_se:.1f}.")
        )
        console.print(table("", *budget_table(found)))
        if found.profile_m is not None:
            console.print(profile_words(found.profile_m, found.coordinate))
        if found.speed_misfit:
            lines = [
                (row.axis, row.level, row.n, row.bias_m_s, row.rmse_m_s)
                for row in found.speed_misfit
            ]
            heads = ("speeds by", "level", ">n", ">bias m/s", ">RMSE m/s")
            console.print(table("Speeds, with friction fitted to each stop", heads, lines))
        console.print("Where it fails:")
        for line in failures(found):
            console.print(f"  {line}", soft_wrap=True)

    emit(context, found, render)
    for note in found.notes:
        warn(note)
    unsure = scores.pareto_k_bad - scores.pareto_k_refitted
    if unsure > 0:
        weigh = "record weighs" if unsure == 1 else "records weigh"
        warn(f"{unsure} {weigh} so much that the left-out density is rough (Pareto k > 0.7).")
