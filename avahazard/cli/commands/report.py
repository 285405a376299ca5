"""`avahazard report`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import EffectFiles, ReportLanguage, StoredModel, output_file
from avahazard.cli.output import emit, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings


def report(
    context: typer.Context,
    name: StoredModel,
    output: Annotated[
        Path,
        output_file("Where to write it: .html. One that is there is replaced."),
    ],
    title: Annotated[str, typer.Option(help="Title of the document.")] = "",
    author: Annotated[str, typer.Option(help="Who answers for it.")] = "",
    place: Annotated[str, typer.Option(help="Commune, valley or region.")] = "",
    date: Annotated[
        str, typer.Option(help="Date of the document; else that of the calibration.")
    ] = "",
    language: Annotated[
        ReportLanguage, typer.Option(help="Language of the report.")
    ] = ReportLanguage.en,
    effect_file: EffectFiles = None,
) -> None:
    """Write a report of a model as one HTML file that needs no network.

    \b
    Examples:
      avahazard report first -o first.html
      avahazard report first -o first.html --title "Val d'Arly" --author "A. Favre"
      avahazard report first -o first-de.html --language de
      avahazard --json report first -o first.html
    """
    from avahazard.report.html.content import Cover  # noqa: PLC0415
    from avahazard.workflow.report import write_report  # noqa: PLC0415

    with show_progress() as progress:
        found = write_report(
            settings(context).database,
            name,
            output,
            cover=Cover(title, author, place, date),
            language=language.value,
            effect_files=effect_file or (),
            report=progress,
        )

    def render(console: Console) -> None:
        size = found.bytes / 1e6
        console.print(
            f"{found.file}: paths {found.n_paths}, events {found.n_events}, "
            f"{size:.1f} MB. Open it in a browser.",
            soft_wrap=True,
        )

    emit(context, found, render)
    warn(*found.lacking, *found.notes)
