"""`avahazard run`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.output import emit, table, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings
from avahazard.results.project import ProjectRun


def run(
    context: typer.Context,
    file: Annotated[
        Path, typer.Argument(metavar="[avahazard.toml]", help="The file of the project.")
    ] = Path("avahazard.toml"),
) -> None:
    """Run a whole project: only what is out of date is done.

    \b
    Examples:
      avahazard run
      avahazard run valley/avahazard.toml
    """
    from avahazard.workflow.run import run_project  # noqa: PLC0415

    with show_progress() as report:
        found = run_project(file, settings(context).database, report)
    emit(context, found, lambda console: _show(console, found))
    warn(*found.notes)


def _show(console: Console, found: ProjectRun) -> None:
    rows = [(step.step, step.state, step.found) for step in found.steps]
    console.print(table(f"Project {found.project}", ("step", "state", "found"), rows))
    console.print(f"The answers are by the model {found.model}, in {found.database}:")
    for file in found.files:
        console.print(f"  {file}", soft_wrap=True)
