"""`avahazard models`."""

from __future__ import annotations

import typer
from rich.console import Console

from avahazard.cli.output import emit, table
from avahazard.cli.settings import settings


def models(context: typer.Context) -> None:
    """List the stored models.

    \b
    Example:
      avahazard models
    """
    from avahazard.workflow.models import show_models  # noqa: PLC0415

    found = show_models(settings(context).database)

    def render(console: Console) -> None:
        if not found:
            console.print("There are no models yet: make one with `avahazard calibrate NAME`.")
            return
        rows = [
            (
                row.model if row.parent is None else f"{row.model} (from {row.parent})",
                row.law,
                ", ".join(row.effects) or None,
                row.method,
                row.n_events,
                row.converged,
                row.created[:10],
            )
            for row in found
        ]
        columns = ("model", "law", "effects", "method", ">events", "converged", "made")
        console.print(table("", columns, rows))

    emit(context, found, render)
