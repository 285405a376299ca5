"""Commands that set a model against measurements: compare, diagnose, ladder, predict."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.model_tables import (
    COORDINATES,
    budget_table,
    crps_words,
    error_words,
    failures,
    profile_words,
    show_scores,
    unit_words,
)
from avahazard.cli.options import EffectFiles, StoredModel, picture
from avahazard.cli.output import emit, settings, table, warn
from avahazard.cli.progress import show_progress
from avahazard.records.plain import plain
from avahazard.results.base import RATIO, amount, bare, unit_of
from avahazard.results.diagnosis import Candidate, Diagnosis
from avahazard.workflow.requests import DiagnoseRequest


def compare(
    context: typer.Context,
    name: StoredModel,
    plot: Annotated[Path | None, picture("Draw where it fails")] = None,
    effect_file: EffectFiles = None,
) -> None:
    """Set a model against the measurements: its scores, and where it fails.

    \b
    Examples:
      avahazard compare first
      avahazard compare first --plot where.png
    """
    from avahazard.workflow.compare import compare as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(
            settings(context).database,
            name,
            effect_files=effect_file or (),
            plot=plot,
            report=report,
        )
    scores, held = found.scores, found.held_out

    def render(console: Console) -> None:
        whole = "paths" if held.by == "path" else "fifths of the events"
        parts = ((f"{whole} held out", held), ("calibrated on", scores))
        columns, cells = show_scores(found.coordinate, *parts)
        console.print(table(f"{name} against the records", columns, cells))
        console.print(
            f"The error of {name}, as add and ladder give it: CRPS where {whole} were held out, "
            f"{bare(held.runout.crps_m, found.coordinate)} {unit_words(found.coordinate)}."
        )
        if held.n_fits is not None and held.n_fits < len(held.groups):
            console.print(f"{len(held.groups)} {whole} were held out in {held.n_fits} parts.")
        console.print(crps_words(found.coordinate))
        console.print(f"bias: predicted mean less recorded. {error_words(found)}")
        console.print(
            f"Log predictive density, each record left out in turn (higher is better): "
            f"{scores.elpd_loo:.1f}"
            + ("." if scores.elpd_loo_se is None else f" ± {scores.elpd_loo_se:.1f}.")
        )
        console.print(table("", *budget_table(found)))
        if found.profile_m is not None:
            console.print(profile_words(found.profile_m, found.coordinate))
        if found.speed_misfit:
            lines = [
                (row.axis, row.level, row.n, row.bias_m_s, row.rmse_m_s)
                for row in found.speed_misfit
            ]
            heads = ("speeds by", "level", ">n", ">bias m/s", ">RMSE m/s")
            console.print(table("Speeds, with friction fitted to each stop", heads, lines))
        console.print("Where it fails:")
        for line in failures(found):
            console.print(f"  {line}", soft_wrap=True)

    emit(context, found, render)
    warn(*found.notes)
    unsure = scores.pareto_k_bad - scores.pareto_k_refitted
    if unsure > 0:
        weigh = "record weighs" if unsure == 1 else "records weigh"
        warn(f"{unsure} {weigh} so much that the left-out density is rough (Pareto k > 0.7).")


ALONE = 0.05
CANDIDATES_SHOWN = 8
NATS_WORDS = (
    "gain: natural logarithm of how many times likelier the records are with the effect (2.3 nats: "
    "10 times, 4.6: 100 times)."
)


def diagnose(
    context: typer.Context,
    name: StoredModel,
    *,
    request: DiagnoseRequest,
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
        found = diagnose_model(settings(context).database, name, request, report)

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
            for c in found.candidates[:CANDIDATES_SHOWN]
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
    for c in found.candidates[:CANDIDATES_SHOWN]:
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


def ladder(
    context: typer.Context,
    plot: Annotated[Path | None, picture("Draw the held-out error and the error budgets")] = None,
) -> None:
    """List every model and its error, oldest first.

    \b
    Examples:
      avahazard ladder
      avahazard ladder --plot ladder.png
    """
    from avahazard.workflow.compare import ladder as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(settings(context).database, plot=plot, report=report)
    extra = ("noise_floor_m", "noise_floor_crps_m")
    document = [{k: v for k, v in row.items() if k not in extra} for row in plain(found.rows)]

    def render(console: Console) -> None:
        cells = [
            (
                row.model,
                row.parent,
                ", ".join(row.added) or None,
                _ladder_error(row.held_out_crps_m, row.coordinate),
                _ladder_error(row.held_out_crps_x_m, "x"),
                _ladder_error(row.crps_m, row.coordinate),
                None if row.elpd_loo is None else f"{row.elpd_loo:.0f}",
                None if row.coverage_90 is None else f"{row.coverage_90:.0%}",
                row.speed_rmse_m_s,
            )
            for row in found.rows
        ]
        coordinates = {row.coordinate for row in found.rows if row.coordinate is not None}
        coordinate = next(iter(coordinates)) if len(coordinates) == 1 else None
        unit = unit_of(coordinate)
        columns = (
            "model", "parent", "added", f">error {unit}", ">in x m", f">own {unit}", ">elpd",
            ">in 90 %", ">m/s",
        )  # fmt: skip
        console.print(table("Every model and its error", columns, cells))
        of = {COORDINATES[known] for known in coordinates}
        console.print(
            f"error: CRPS where held out, of {' or '.join(sorted(of))}; in x: the same of the "
            "distance along the path; own: on the records that the model was calibrated on, as "
            "the share in 90 % and the speeds (RMSE, m/s) are."
        )
        console.print(crps_words(coordinate))
        floors = [row.noise_floor_crps_m for row in found.rows if row.noise_floor_crps_m]
        if floors:
            # What the error of a volume does to a stop is the model's own; gibbs knows none.
            low, high = (amount(floor, coordinate) for floor in (min(floors), max(floors)))
            console.print(
                f"Errors of the records alone (runout, volume, release) would leave "
                f"{low if low == high else f'{low} to {high}, by model'}; what varies from "
                "avalanche to avalanche comes on top."
            )

    emit(context, document, render)
    warn(*found.notes)


def _ladder_error(value: float | None, coordinate: str | None) -> str | None:
    return None if value is None else bare(value, coordinate, 0)


def predict(
    context: typer.Context,
    name: StoredModel,
    events: Annotated[
        Path, typer.Argument(metavar="EVENTS.csv", help="Events.", show_default=False)
    ],
    effect_file: EffectFiles = None,
) -> None:
    """Predict the runout of each event of a file; its own runout only serves for scores.

    \b
    Example:
      avahazard predict first new-events.csv
    """
    from avahazard.workflow.predict import predict as run  # noqa: PLC0415

    found = run(settings(context).database, name, events, effect_files=effect_file or ())
    rows, scores = found.events, found.scores
    # Elevations, unless `coordinate` of a row says otherwise (docs/results.md).
    document = rows if scores is None else {"events": rows, "scores": scores}

    def render(console: Console) -> None:
        columns = ("event", "path", ">mean", ">sd", ">q05", ">median", ">q95", ">leaves")
        cells = [
            (
                row.event_id,
                row.path_id,
                *(
                    bare(value, row.coordinate, 0)
                    for value in (row.mean_m, row.sd_m, row.q05_m, row.q50_m, row.q95_m)
                ),
                f"{row.p_left_profile:.0%}",
            )
            for row in rows
        ]
        kinds = {row.coordinate for row in rows}
        of = {"elevation": "elevations in m", "length": "lengths in m", RATIO: "H/L"}
        what = of.get(
            kinds.pop() if len(kinds) == 1 else "",
            "elevations in m; lengths in m where there is no path",
        )
        console.print(table(f"Predicted stops, {what}", columns, cells))
        if scores is not None:
            columns_of, lines = show_scores(scores.coordinate, (name, scores))
            console.print(table("Against the file's own runouts", columns_of, lines))
            console.print(crps_words(scores.coordinate))

    emit(context, document, render)
    warn(*found.notes)
