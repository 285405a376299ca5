"""`avahazard runout`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from rich.console import Console

from avahazard.cli.output import emit, table, warn
from avahazard.cli.settings import settings

SHOWN = 10
"""Places in the table of speeds for people."""


def _positive(mu: float) -> float:
    if not (math.isfinite(mu) and mu > 0.0):
        raise typer.BadParameter("it must be a number over 0, such as 0.4")
    return mu


def _needs_model(volume: float | None) -> float | None:
    if volume is not None:
        raise typer.BadParameter("a volume changes the run only through a model; there is none")
    return volume


def runout(
    context: typer.Context,
    path: Annotated[str, typer.Argument(help="The path_id of a path.", show_default=False)],
    mu: Annotated[
        float,
        typer.Option(
            "--mu", metavar="MU", callback=_positive, help="Coulomb friction.", show_default=False
        ),
    ],
    volume: Annotated[
        float | None,
        typer.Option(metavar="M3", callback=_needs_model, help="Volume, for a model's effects."),
    ] = None,
) -> None:
    """Run the block once: its stop and its speeds."""
    from avahazard.workflow.running import run_path  # noqa: PLC0415

    del volume
    document = run_path(settings(context).database, path, mu)

    def render(console: Console) -> None:
        console.print(_ending(document), soft_wrap=True)
        if document["status"] != "not_released":
            rows = [(f"{p['x_m']:.0f}", f"{p['speed_m_s']:.1f}") for p in _few(document["speeds"])]
            console.print(table("", (">x m", ">speed m/s"), rows))
            console.print(f"Largest speed {document['speed_max_m_s']:.1f} m/s.")

    emit(context, document, render)
    if math.isfinite(document["lift_off_x_m"]):
        warn(f"the block loses the ground at x = {document['lift_off_x_m']:.0f} m.")


def _ending(document: dict[str, Any]) -> str:
    start = (
        f"{document['path_id']}, μ = {document['mu']:g}: released at "
        f"{document['release_elevation_m']:.0f} m, "
    )
    if document["status"] == "left_profile":
        return f"{start}leaves the profile at its end."
    if document["status"] == "not_released":
        return f"{start}does not move: the slope is less than μ."
    return (
        f"{start}stops at {document['runout_elevation_m']:.1f} m "
        f"(x = {document['runout_x_m']:.1f} m)."
    )


def _few(speeds: Sequence[dict[str, float]]) -> list[dict[str, float]]:
    """About `SHOWN` of the places, evenly, with the first and the last."""
    last = len(speeds) - 1
    return [speeds[i] for i in sorted({round(k * last / SHOWN) for k in range(SHOWN + 1)})]
