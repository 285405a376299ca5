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

    document = show_model(settings(context).database, name)

    def render(console: Console) -> None:
        show_calibration(console, document)
        line = f"Stored {document['created'].replace('T', ' ').removesuffix('Z')} (UTC)"
        parent = f", from {document['parent']}" if document["parent"] else ""
        fingerprint = document["data_fingerprint"][:12]
        console.print(f"{line}{parent}, on the records {fingerprint}….")

    emit(context, document, render)
    for note in document["notes"]:
        warn(note)
