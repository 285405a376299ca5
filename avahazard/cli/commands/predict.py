"""`avahazard predict`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.comparison_table import crps_words, show_scores
from avahazard.cli.options import EffectFiles, StoredModel
from avahazard.cli.output import emit, table, warn
from avahazard.cli.settings import settings
from avahazard.results.amounts import RATIO, bare


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
        columns = ("event", "path", ">mean", ">sd", ">q05", ">median", ">q95", ">leaves")
        cells = [
            (
                row.event_id,
                row.path_id,
                *(
                    bare(value, row.coordinate, 0)
                    for value in (row.mean_m, row.sd_m, row.q05_m, row.q50_m, row.q95_m)
                ),
                f"{row.p_left_profile:.0%}",
            )
            for row in rows
        ]
        kinds = {row.coordinate for row in rows}
        of = {"elevation": "elevations in m", "length": "lengths in m", RATIO: "H/L"}
        what = of.get(
            kinds.pop() if len(kinds) == 1 else "",
            "elevations in m; lengths in m where there is no path",
        )
        console.print(table(f"Predicted stops, {what}", columns, cells))
        if scores is not None:
            columns_of, lines = show_scores(scores.coordinate, (name, scores))
            console.print(table("Against the file's own runouts", columns_of, lines))
            console.print(crps_words(scores.coordinate))

    emit(context, document, render)
    warn(*found.notes)
