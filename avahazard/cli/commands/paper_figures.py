"""`avahazard paper-figures`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import EffectFiles, OnlyPaths
from avahazard.cli.output import emit, table, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings


class Kind(StrEnum):
    """Kinds of pictures."""

    png = "png"
    svg = "svg"
    pdf = "pdf"


def paper_figures(
    context: typer.Context,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="Stored models; without any, only what needs none is drawn.",
            show_default=False,
        ),
    ] = None,
    folder: Annotated[
        Path,
        typer.Option(help="Where the pictures are written."),
    ] = Path("paper-figures"),
    path: OnlyPaths = None,
    kind: Annotated[Kind, typer.Option("--format", help="The kind of pictures.")] = Kind.png,
    effect_file: EffectFiles = None,
) -> None:
    """Draw every figure of Ancey (2005) from the records and stored models.

    \b
    Examples:
      avahazard paper-figures
      avahazard paper-figures all-metropolis all-gibbs --folder figures
      avahazard paper-figures first --path P01 --format pdf
    """
    from avahazard.workflow.paper_figures import paper_figures as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(
            settings(context).database,
            names or (),
            folder,
            paths=path or (),
            kind=kind.value,
            effect_files=effect_file or (),
            report=report,
        )

    def render(console: Console) -> None:
        rows = [(row.figure, row.shows, Path(row.file).name if row.file else None) for row in found]
        console.print(table(f"Figures in {folder}", ("figure", "shows", "file"), rows))

    emit(context, found, render)
    for row in found:
        for note in row.notes or ():
            warn(f"No figure {row.figure} ({row.shows}): {note}")
