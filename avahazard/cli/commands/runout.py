"""`avahazard runout`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import EffectFiles, OnePath, picture, positive
from avahazard.cli.output import emit, evenly, table, warn
from avahazard.cli.runout_table import show_table
from avahazard.cli.settings import settings
from avahazard.results.terrain import Runout

SHOWN = 10
"""Places in the table of speeds for people."""


def runout(
    context: typer.Context,
    path: OnePath,
    mu: Annotated[
        float | None, typer.Option(metavar="MU", callback=positive, help="Coulomb friction.")
    ] = None,
    volume: Annotated[
        float | None,
        typer.Option(metavar="M3", callback=positive, help="Volume: the model then gives MU."),
    ] = None,
    model: Annotated[
        str | None, typer.Option(metavar="NAME", help="Run with the effects of a stored model.")
    ] = None,
    curve: Annotated[
        bool, typer.Option("--table", help="Tell F(μ) and its derivative F′(μ) as well.")
    ] = False,
    plot: Annotated[
        Path | None, picture("Draw the run and its speeds, or F and F′ with --table")
    ] = None,
    effect_file: EffectFiles = None,
) -> None:
    """Run the block once: its stop and its speeds; or F(μ), where it stops under any friction.

    \b
    Examples:
      avahazard runout P01 --mu 0.4
      avahazard runout P01 --model first --volume 50000
      avahazard runout P01 --mu 0.4 --table --plot curve.png
    """
    if mu is None and (model is None or volume is None):
        raise typer.BadParameter("Give --mu MU, or --model NAME with --volume M3.")
    if volume is not None and model is None:
        raise typer.BadParameter("A --volume changes the run only through a --model.")
    found = _run(settings(context).database, path, mu, volume, model, curve, plot, effect_file)

    def render(console: Console) -> None:
        console.print(_ending(found), soft_wrap=True)
        if found.status != "not_released":
            rows = [(f"{p.x_m:.0f}", f"{p.speed_m_s:.1f}") for p in evenly(found.speeds, SHOWN)]
            console.print(table("", (">x m", ">speed m/s"), rows))
            console.print(f"Largest speed {found.speed_max_m_s:.1f} m/s.")
        show_table(console, found)

    emit(context, found, render)
    if found.lift_off_x_m is not None:
        warn(f"the block loses the ground at x = {found.lift_off_x_m:.0f} m.")
    warn(*(found.notes or ()))


def _run(
    database: str,
    path: str,
    mu: float | None,
    volume: float | None,
    model: str | None,
    curve: bool,
    plot: Path | None,
    effect_files: list[Path] | None,
) -> Runout:
    from avahazard.workflow.runout import run_model, run_path  # noqa: PLC0415

    if model is not None:
        return run_model(
            database,
            path,
            model,
            volume_m3=volume,
            mu=mu,
            table=curve,
            plot=plot,
            effect_files=effect_files or (),
        )
    assert mu is not None
    return run_path(database, path, mu, table=curve, plot=plot)


def _ending(found: Runout) -> str:
    by = f" ({found.mu_from}, {found.model})" if found.model else ""
    start = (
        f"{found.path_id}, μ = {found.mu:.4g}{by}: released at {found.release_elevation_m:.0f} m, "
    )
    if found.status == "left_profile":
        return f"{start}leaves the profile at its end."
    if found.status == "not_released":
        return f"{start}does not move: the slope is less than μ."
    return f"{start}stops at {found.runout_elevation_m:.1f} m (x = {found.runout_x_m:.1f} m)."
