"""`avahazard model`."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.model_table import show_calibration
from avahazard.cli.output import emit, warn
from avahazard.cli.settings import settings


def model(
    context: typer.Context,
    name: Annotated[str, typer.Argument(help="The name of a model.", show_default=False)],
) -> None:
    """Show a stored model: its posterior, and whether it converged.

    \b
    Example:
      avahazard model first
    """
    from avahazard.workflow.models import show_model  # noqa: PLC0415

    found = show_model(settings(context).database, name)

    def render(console: Console) -> None:
        show_calibration(console, found)
        line = f"Stored {str(found.created).replace('T', ' ').removesuffix('Z')} (UTC)"
        parent = f", from {found.parent}" if found.parent else ""
        fingerprint = found.data_fingerprint[:12]
        console.print(f"{line}{parent}, on the records {fingerprint}….")

    emit(context, found, render)
    for note in found.notes:
        warn(note)
