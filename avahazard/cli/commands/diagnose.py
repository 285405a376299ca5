"""`avahazard diagnose`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from avahazard.cli.options import EffectFiles, StoredModel, picture
from avahazard.cli.output import emit, table
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings

ALONE = 0.05
SHOWN = 8


def diagnose(
    context: typer.Context,
    name: StoredModel,
    worlds: Annotated[
        int, typer.Option(min=39, help="Worlds made from the model to tell chance by.")
    ] = 199,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the made worlds.")] = 0,
    plot: Annotated[Path | None, picture("Draw the candidates")] = None,
    effect_file: EffectFiles = None,
) -> None:
    """Ask which effect a model lacks, if any; what to measure next.

    \b
    Examples:
      avahazard diagnose first
      avahazard diagnose first --worlds 399 --plot candidates.png
    """
    from avahazard.report.verdict_words import verdict_words  # noqa: PLC0415
    from avahazard.workflow.diagnose import diagnose_model  # noqa: PLC0415

    with show_progress() as report:
        document = diagnose_model(
            settings(context).database,
            name,
            n_worlds=worlds,
            seed=seed,
            effect_files=effect_file or (),
            plot=plot,
            report=report,
        )

    def render(console: Console) -> None:
        console.print(verdict_words(document, document["model"]), soft_wrap=True)
        rows = [
            (
                c["effect"],
                f"{c['gain']:.1f}",
                f"{c['p_value']:.3f}",
                "" if c["error_after_m"] is None else f"{c['error_after_m']:.1f}",
                ", ".join(c["confounded_with"]),
            )
            for c in document["candidates"][:SHOWN]
        ]
        columns = ("effect", ">gain, nats", ">p", ">error after, m", "looks like")
        console.print(table(f"Candidates (error now {_before(document)} m)", columns, rows))
        best = document["candidates"][0] if document["candidates"] else None
        if document["missing"] and best is not None and best["effect"] in document["missing"]:
            console.print(best["physics"], soft_wrap=True)
        if document["verdict"] == "adequate" and best is not None:
            _nearest(console, best, len(document["candidates"]))
        _next_steps(console, document)

    emit(context, document, render)


def _nearest(console: Console, best: dict[str, Any], n_tried: int) -> None:
    """A candidate that would count had it been the only question."""
    if best["p_value_alone"] < ALONE:
        console.print(
            f"{best['effect']} comes nearest: p = {best['p_value_alone']:.3f} by itself, "
            f"{best['p_value']:.2f} as the best of {n_tried}. Only if you expected it before you "
            "looked does the first count: then add it, and compare.",
            soft_wrap=True,
        )


def _before(document: dict[str, Any]) -> str:
    candidates = document["candidates"]
    return f"{candidates[0]['error_before_m']:.1f}" if candidates else "-"


def _next_steps(console: Console, document: dict[str, Any]) -> None:
    if document["heavy_tails"]:
        console.print(
            "Friction scatters with heavy tails: Student's t was used. Look at wrong records: "
            f"{', '.join(document['suspect_events'][:6]) or 'none stands out'}.",
            soft_wrap=True,
        )
    for effect, loss in document["still_needed"].items():
        need = "is still needed" if loss > 0 else "is no longer needed"
        console.print(f"{effect} {need} (evidence {loss:+.1f} nats).")
    for step in document["measure_next"][:3]:
        console.print(
            f"To measure next: {step['measurement']} ({step['expected_gain']:.1f} nats expected).",
            soft_wrap=True,
        )
    if document["verdict"] == "missing-effect":
        effect = document["missing"][0]
        console.print(f"Add it: avahazard add {document['model']} {effect} --as NEW")
