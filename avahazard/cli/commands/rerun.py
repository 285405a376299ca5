"""`avahazard rerun`."""

from __future__ import annotations

import typer
from rich.console import Console

from avahazard.cli.options import EffectFiles, StoredModel
from avahazard.cli.output import emit, table, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings


def rerun(context: typer.Context, name: StoredModel, effect_file: EffectFiles = None) -> None:
    """Calibrate a stored model again, and say whether the result is identical.

    \b
    Example:
      avahazard rerun first
    """
    from avahazard.workflow.rerun import rerun as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(settings(context).database, name, effect_files=effect_file or (), report=report)

    def render(console: Console) -> None:
        if found.identical:
            console.print(f"{name}: identical, every draw of {found.n_parameters} parameters.")
            return
        rows = [(key, d.stored_mean, d.new_mean, d.largest) for key, d in found.differences.items()]
        columns = ("", ">stored mean", ">mean now", ">largest difference")
        console.print(table(f"{name}: not identical", columns, rows))

    emit(context, found, render)
    warn(*found.notes)
