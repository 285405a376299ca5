"""`avahazard diagnose`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.options import EffectFiles, StoredModel, picture
from avahazard.cli.output import emit, table, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings
from avahazard.results.amounts import bare, unit_of
from avahazard.results.diagnosis import Candidate, Diagnosis

ALONE = 0.05
SHOWN = 8
NATS_WORDS = (
    "gain: natural logarithm of how many times likelier the records are with the effect (2.3 nats: "
    "10 times, 4.6: 100 times)."
)


def diagnose(
    context: typer.Context,
    name: StoredModel,
    expect: Annotated[
        list[str] | None,
        typer.Option(
            metavar="EFFECT",
            help="Declared before looking: tested first, at its own level; may be given again.",
        ),
    ] = None,
    worlds: Annotated[
        int,
        typer.Option(
            min=39,
            help="Worlds made from the model to tell chance by; fewer than 199 name no "
            "hidden pair.",
        ),
    ] = 199,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the made worlds.")] = 0,
    plot: Annotated[Path | None, picture("Draw the candidates")] = None,
    effect_file: EffectFiles = None,
) -> None:
    """Ask which effect a model lacks, if any; what to measure next.

    \b
    Examples:
      avahazard diagnose first
      avahazard diagnose first --expect snow-type
      avahazard diagnose first --worlds 399 --plot candidates.png
    """
    from avahazard.report.html.words import chance  # noqa: PLC0415
    from avahazard.report.verdict_words import verdict_words  # noqa: PLC0415
    from avahazard.workflow.diagnose import diagnose_model  # noqa: PLC0415

    with show_progress() as report:
        found = diagnose_model(
            settings(context).database,
            name,
            expect=expect or (),
            n_worlds=worlds,
            seed=seed,
            effect_files=effect_file or (),
            plot=plot,
            report=report,
        )

    def render(console: Console) -> None:
        console.print(verdict_words(found, found.model), soft_wrap=True)
        if found.declared is not None:
            words = ", ".join(found.declared.effects)
            console.print(f"Declared beforehand ({found.declared.at}), tested first: {words}.")
        rows = [
            (
                c.effect,
                f"{c.gain:.1f}",
                chance(c.p_value, 1.0 / (found.n_worlds + 1)),
                "" if c.error_after_m is None else bare(c.error_after_m, found.coordinate),
                ", ".join(c.confounded_with),
            )
            for c in found.candidates[:SHOWN]
        ]
        unit = unit_of(found.coordinate)
        columns = ("effect", ">gain, nats", ">p", f">CRPS then {unit}", "looks like")
        title = (
            f"Candidates (CRPS at best fit on records of the calibration: {_before(found)} {unit})"
        )
        console.print(table(title, columns, rows))
        console.print(NATS_WORDS, soft_wrap=True)
        best = found.candidates[0] if found.candidates else None
        if found.missing and best is not None and best.effect in found.missing:
            console.print(best.physics, soft_wrap=True)
        if found.verdict == "adequate" and best is not None:
            _nearest(console, best, len(found.candidates))
        _next_steps(console, found)

    emit(context, found, render)
    warn(*found.notes)


def _nearest(console: Console, best: Candidate, n_tried: int) -> None:
    """A candidate that would count had it been the only question."""
    if best.p_value_alone < ALONE:
        console.print(
            f"{best.effect} comes nearest: p = {best.p_value_alone:.3f} by itself, "
            f"{best.p_value:.2f} as the best of {n_tried}. Only if you expected it before you "
            "looked does the first count: then add it, and compare.",
            soft_wrap=True,
        )


def _before(found: Diagnosis) -> str:
    if not found.candidates:
        return "-"
    return bare(found.candidates[0].error_before_m, found.coordinate)


def _witnesses(console: Console, found: Diagnosis) -> None:
    """What the measured force says of the candidates on the motion."""
    for c in found.candidates[:SHOWN]:
        if c.force_witness is not None:
            value, se = c.force_witness.value, c.force_witness.se
            fitted = ", ".join(f"{k} {v:.3g}" for k, v in c.parameters.items())
            console.print(
                f"The measured force has {value:.2g} ± {se:.2g} of {c.effect} (fitted: {fitted}).",
                soft_wrap=True,
            )


def _next_steps(console: Console, found: Diagnosis) -> None:
    _witnesses(console, found)
    if found.impossible_stops:
        n = len(found.impossible_stops)
        console.print(
            f"{n} recorded {'stop' if n == 1 else 'stops'} on ground too steep for a block to stop "
            f"there: {', '.join(found.impossible_stops[:6])}{', …' if n > 6 else ''}.",
            soft_wrap=True,
        )
    if found.heavy_tails:
        console.print(
            "Friction scatters with heavy tails: Student's t was used. Look at wrong records: "
            f"{', '.join(found.suspect_events[:6]) or 'none stands out'}.",
            soft_wrap=True,
        )
    for effect, loss in found.still_needed.items():
        need = "is still needed" if loss > 0 else "is no longer needed"
        console.print(f"{effect} {need} (evidence {loss:+.1f} nats).")
    for step in found.measure_next[:3]:
        console.print(
            f"To measure next: {step.measurement} ({step.expected_gain:.1f} nats expected).",
            soft_wrap=True,
        )
    if found.pairs:
        effects = " ".join(found.pairs[-1].effects)
        console.print(
            f"Add them together: avahazard add {found.model} {effects} --as NEW", soft_wrap=True
        )
    elif found.verdict == "missing-effect":
        effect = found.missing[0]
        console.print(f"Add it: avahazard add {found.model} {effect} --as NEW")
