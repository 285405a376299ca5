"""`avahazard path`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import OnePath, picture
from avahazard.cli.output import emit, number, table, warn
from avahazard.cli.settings import settings


def path(
    context: typer.Context,
    path: OnePath,
    plot: Annotated[Path | None, picture()] = None,
) -> None:
    """Show how the profile of a path was smoothed, and check it.

    \b
    Examples:
      avahazard path P01
      avahazard path P01 --plot profile.png
    """
    from avahazard.workflow.path import view_path  # noqa: PLC0415

    found = view_path(settings(context).database, path, plot)
    fit = found.fit
    how = (
        f"Legendre polynomial of degree {fit.degree}"
        if fit.method == "legendre"
        else f"smoothing spline ({number(fit.smoothing)})"
    )

    def render(console: Console) -> None:
        rows = (
            ("points", found.n_points),
            ("events", found.n_events),
            ("length m", found.length_m),
            ("drop m", found.drop_m),
            ("smoothed by", how),
            (f"error of a point, {fit.sigma_from} m", fit.elevation_sigma_m),
            ("misfit (rms) m", fit.rms_m),
            ("misfit of the polynomial (rms) m", fit.polynomial_rms_m),
            ("largest deviation m", fit.max_deviation_m),
            ("error of the ground m", fit.ground_sd_m),
            ("length of the block m", fit.block_m),
            ("falls all the way", found.monotone),
            ("smallest radius of curvature m", found.min_curvature_radius_m),
            ("length of the flow m", found.flow_length_m),
        )
        console.print(table("", (path, ">"), rows))

    emit(context, found, render)
    warn(*found.notes)
