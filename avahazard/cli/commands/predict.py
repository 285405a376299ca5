"""`avahazard predict`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.comparison_table import CRPS_WORDS, show_scores
from avahazard.cli.options import EffectFiles, StoredModel
from avahazard.cli.output import emit, table, warn
from avahazard.cli.settings import settings


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
        columns = ("event", "path", ">mean m", ">sd", ">q05", ">median", ">q95", ">leaves")
        cells = [
            (
                row.event_id,
                row.path_id,
                f"{row.mean_m:.0f}",
                f"{row.sd_m:.0f}",
                f"{row.q05_m:.0f}",
                f"{row.q50_m:.0f}",
                f"{row.q95_m:.0f}",
                f"{row.p_left_profile:.0%}",
            )
            for row in rows
        ]
        kinds = {row.coordinate for row in rows}
        what = {"elevation": "elevations", "length": "lengths"}.get(
            kinds.pop() if len(kinds) == 1 else "", "elevations; lengths where there is no path"
        )
        console.print(table(f"Predicted stops, {what} in m", columns, cells))
        if scores is not None:
            columns_of, lines = show_scores(scores.coordinate, (name, scores))
            console.print(table("Against the file's own runouts", columns_of, lines))
            console.print(CRPS_WORDS)

    emit(context, document, render)
    for note in found.notes:
        warn(note)
