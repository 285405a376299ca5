"""`avahazard effect`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.output import emit, number, table
from avahazard.cli.settings import settings
from avahazard.results.catalogue import EffectDetails, WrittenTemplate


def effect(
    context: typer.Context,
    key: Annotated[str, typer.Argument(help="An effect, or the word new.", show_default=False)],
    file: Annotated[
        Path | None,
        typer.Argument(help="With new: the effect file to write.", show_default=False),
    ] = None,
) -> None:
    """Show the physics of one effect; `effect new FILE` writes a template for one's own.

    \b
    Examples:
      avahazard effect forest-drag
      avahazard effect new mine.py
    """
    from avahazard.workflow.effects import show_effect, write_template  # noqa: PLC0415

    if (key == "new") != (file is not None):
        raise typer.BadParameter("it is either KEY or new FILE", ctx=context, param_hint="KEY")
    if file is not None:
        written = write_template(file)
        emit(context, written, lambda console: _say_next(console, written))
        return
    found = show_effect(settings(context).database, key)
    emit(context, found, lambda console: _render(console, found))


def _say_next(console: Console, written: WrittenTemplate) -> None:
    console.print(f"Written: {written.file}", soft_wrap=True)
    console.print(
        f"Change it, then: avahazard add MODEL KEY --as NEW --effect-file {written.file}",
        soft_wrap=True,
    )


def _render(console: Console, effect: EffectDetails) -> None:
    console.print(f"{effect.key}: {effect.meaning}")
    if effect.acts_on:
        console.print(f"It acts on: {effect.acts_on}.")
    console.print(f"It needs: {effect.needs}.")
    lacking = effect.lacking
    if lacking is None:
        console.print("These data can tell it.")
    else:
        console.print(f"These data cannot tell it: {lacking}.")
    if effect.parameters:
        cells = [
            (
                p.name,
                p.unit,
                p.neutral,
                f"{number(p.prior_mean)} ± {number(p.prior_sd)}",
                _range(p.low, p.high),
            )
            for p in effect.parameters
        ]
        columns = ("parameter", "unit", ">neutral", ">prior", ">range")
        console.print(table("", columns, cells))


def _range(low: float | None, high: float | None) -> str:
    if low is None and high is None:
        return "any"
    return f"{'' if low is None else number(low)} to {'' if high is None else number(high)}"
