"""`avahazard friction`."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from statistics import median
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import EffectFiles, picture
from avahazard.cli.output import emit, number, table, warn
from avahazard.cli.settings import settings
from avahazard.results.friction import ApparentEvent, Frictions, PerturbationCheck


def _kappa(text: str) -> str:
    try:
        fits = text == "auto" or 0.0 < float(text) < math.inf
    except ValueError:
        fits = False
    if not fits:
        raise typer.BadParameter("it must be a number over 0, such as 5, or auto")
    return text


def friction(
    context: typer.Context,
    path: Annotated[
        str | None,
        typer.Argument(help="Only events of this path.", show_default=False),
    ] = None,
    kappa: Annotated[
        str,
        typer.Option(
            metavar="K",
            callback=_kappa,
            help="Sharpness of the density; auto lets the records choose.",
        ),
    ] = "5",
    model: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="With the effects of a stored model on motion and record."
        ),
    ] = None,
    plot: Annotated[
        Path | None, picture("Draw the densities, and by a model its law and the events")
    ] = None,
    effect_file: EffectFiles = None,
) -> None:
    """Show the apparent friction of the events and its density.

    \b
    Examples:
      avahazard friction
      avahazard friction P01 --kappa auto --plot density.png
      avahazard friction --model first --plot law.png
    """
    from avahazard.workflow.friction import show_frictions  # noqa: PLC0415

    found = show_frictions(
        settings(context).database,
        path,
        "auto" if kappa == "auto" else float(kappa),
        plot,
        model,
        effect_file or (),
    )

    def render(console: Console) -> None:
        if path is None:
            _render_paths(console, found)
        else:
            _render_events(console, found)
        _render_perturbation(console, found.perturbation)

    emit(context, found, render)
    warn(*(found.notes or ()))
    for jump in found.jumps:
        warn(
            f"{jump.path_id}: the runout jumps by up to {jump.jump_m:.0f} m (near μ = "
            f"{jump.mu:.3f}): no friction stops the block in between."
        )


def _render_paths(console: Console, found: Frictions) -> None:
    kappas = {density.path_id: density.kappa for density in found.density}
    groups: dict[str | None, list[ApparentEvent]] = {}
    for event in found.events:
        groups.setdefault(event.path_id, []).append(event)
    if len(groups) > 1:
        groups["all"] = list(found.events)
    rows = []
    for name, events in groups.items():
        known = [event.mu for event in events if event.mu is not None]
        odd = Counter(event.status for event in events if event.status != "unique")
        rows.append(
            (
                name,
                len(events),
                min(known, default=None),
                median(known) if known else None,
                max(known, default=None),
                kappas.get("all" if name is None else name),
                ", ".join(f"{n} {status}" for status, n in odd.items()) or None,
            )
        )
    columns = ("path", ">events", ">lowest μ", ">median", ">highest", ">κ", "not unique")
    console.print(table(_title(found), columns, rows))


def _render_events(console: Console, found: Frictions) -> None:
    rows = [(event.event_id, event.mu, event.mu_sd, _status(event)) for event in found.events]
    console.print(table(_title(found), ("event", ">μ", ">sd", "status"), rows))
    for density in found.density[:1]:
        peak = density.mu[density.pdf.index(max(density.pdf))]
        console.print(f"Density: κ = {number(density.kappa)}, highest at μ = {peak:.3f}.")


def _title(found: Frictions) -> str:
    return f"Apparent friction{f', with the effects of {found.model}' if found.model else ''}"


def _status(event: ApparentEvent) -> str:
    """The status, with what is known of μ where that is an interval."""
    low, high = event.mu_low, event.mu_high
    match event.status:
        case "jump" | "several":
            return f"{event.status}: {low:.3f} to {high:.3f}"
        case "below" if high is not None:
            return f"below {high:.3f}"
        case "above" if low is not None:
            return f"above {low:.3f}"
    return str(event.status)


def _render_perturbation(console: Console, check: PerturbationCheck) -> None:
    if check.mu_sd_median is None or check.mu_sd_max is None:
        return
    console.print(
        f"Records moved within their errors {check.n_replicates} times: μ moves by "
        f"{check.mu_sd_median:.3f} (sd, median event), {check.mu_sd_max:.3f} at most."
    )
    if check.law:
        columns = (f"{check.law} law", ">value", ">± se", ">mean when moved", ">± sd")
        rows = [(name, p.value, p.se, p.mean, p.sd) for name, p in check.parameters.items()]
        console.print(table("", columns, rows))
