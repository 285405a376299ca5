"""`avahazard synth`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.output import emit
from avahazard.message import counted


def synth(
    context: typer.Context,
    folder: Annotated[Path, typer.Argument(help="A new or empty folder.")],
    effect: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY", help="An effect that is at work; may be given again."),
    ] = None,
    strength: Annotated[
        float, typer.Option(min=0.0, max=2.0, help="Of the effects: 1 is plain to see.")
    ] = 1.0,
    events: Annotated[int, typer.Option(min=1, help="How many events.")] = 240,
    paths: Annotated[int, typer.Option(min=1, help="How many paths.")] = 9,
    speeds: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            max=1.0,
            help="Share of events with measured speeds; by itself only where an effect needs them.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Another seed, another world.")] = 0,
) -> None:
    """Make a world with known hidden effects, to try the program on.

    \b
    Examples:
      avahazard synth my-records --events 90 --paths 5
      avahazard synth hidden --effect forest-drag --effect snow-type --seed 7
    """
    from avahazard.workflow.synth import synthesise  # noqa: PLC0415

    found = synthesise(
        folder,
        effect or [],
        strength=strength,
        n_events=events,
        n_paths=paths,
        speeds=speeds,
        seed=seed,
    )

    def render(console: Console) -> None:
        hidden = ", ".join(found.effects) or "none"
        console.print(
            f"{counted(found.n_events, 'event')} on {counted(found.n_paths, 'path')}, "
            f"{found.n_left_profile} beyond the profile, {found.n_speeds} speeds."
        )
        console.print(f"Hidden effects: {hidden}.")
        for file in found.files:
            console.print(file, soft_wrap=True)

    emit(context, found, render)
