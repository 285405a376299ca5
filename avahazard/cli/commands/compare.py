"""`avahazard compare`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.comparison_table import failures, show_scores
from avahazard.cli.options import EffectFiles, StoredModel, picture
from avahazard.cli.output import emit, table, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings


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
        parts = show_scores(("calibrated on all", scores), (f"{whole} held out", held))
        console.print(table(f"{name} against the records", *parts))
        floor = scores.runout.noise_floor_m
        console.print(
            f"The records' own errors leave {floor:.0f} m (CRPS "
            f"{scores.runout.noise_floor_crps_m:.0f} m), whatever the model."
        )
        console.print(
            f"Log predictive density, each record left out in turn: {scores.elpd_loo:.1f} "
            f"± {scores.elpd_loo_se:.1f}."
        )
        if found.speed_misfit:
            cells = [
                (row.axis, row.level, row.n, row.bias_m_s, row.rmse_m_s)
                for row in found.speed_misfit
            ]
            columns = ("speeds by", "level", ">n", ">bias m/s", ">RMSE m/s")
            console.print(table("Friction fitted to each stop", columns, cells))
        console.print("Where it fails:")
        for line in failures(found):
            console.print(f"  {line}", soft_wrap=True)

    emit(context, found, render)
    unsure = scores.pareto_k_bad - scores.pareto_k_refitted
    if unsure > 0:
        warn(f"{unsure} records weigh so much that the left-out density is rough (Pareto k > 0.7).")
