"""`avahazard demo`."""

from __future__ import annotations

import sys
from pathlib import Path
from shutil import which
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.demo_words import last_model, show_loop
from avahazard.cli.hazard_table import show_bounds
from avahazard.cli.model_table import show_calibration
from avahazard.cli.output import emit, warn
from avahazard.cli.progress import show_progress
from avahazard.results.made import Demo


def demo(
    context: typer.Context,
    folder: Annotated[
        Path, typer.Option(help="Where its database and files go; made anew each time.")
    ] = Path("avahazard-demo"),
) -> None:
    """Do the main job on the bundled data, a twin of the paper's seven paths; find what is hidden.

    The second part makes a world with one effect that its model is not told of, lets diagnose
    name what is missing, adds that, and says how far the error falls.

    \b
    Examples:
      avahazard demo
      avahazard demo --folder try
    """
    from avahazard.workflow.demo import run_demo  # noqa: PLC0415

    with show_progress() as report:
        found = run_demo(folder, report)
    emit(context, found, lambda console: _show(console, found))
    warn(*found.notes, *found.loop.notes)


def _show(console: Console, found: Demo) -> None:
    console.print(found.twin)
    console.print("Nobody may use them to judge a real place.\n")
    for model in (found.model, found.gibbs):
        show_calibration(console, model)
        console.print()
    console.print("The twin was made with a = 0.519, n = 3.36e-07 1/m3, sigma = 0.158.\n")
    show_bounds(console, found.hazard)
    show_loop(console, found.loop)
    console.print("\nFiles:")
    database, bounds, picture, report, *data = found.files
    for words, file in (
        ("database", database),
        ("bounds of the twin's paths", bounds),
        ("picture of them", picture),
        ("report, for a browser", report),
        ("the twin itself", str(Path(data[0]).parent)),
        ("database of the made world", found.loop.database),
        ("its records", str(Path(found.loop.files[-1]).parent)),
    ):
        console.print(f"  {words}: {file}", soft_wrap=True)
    console.print("\nGo on with it, for example:")
    name = found.model.model
    program = "avahazard" if which("avahazard") else sys.argv[0]
    for file, words in (
        (database, f"model {name}"),
        (database, f"hazard {name} -T 30 -T 300"),
        (found.loop.database, "ladder"),
        (found.loop.database, f"friction --model {last_model(found.loop)}"),
    ):
        console.print(f"  {program} --db {file} {words}", soft_wrap=True)
    console.print(f"\nOne file to open, in a browser: {found.loop.report}", soft_wrap=True)
    console.print(
        f"It is the report of the model “{last_model(found.loop)}” of the made world: where it "
        "fails, what was found, and the error that is left."
    )
