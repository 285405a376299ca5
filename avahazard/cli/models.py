"""Commands on models: calibrate, models, model, rerun, compare, diagnose, add, predict, effects.

The ladder of models too, and one effect.
"""

import shlex
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from avahazard.cli.options import EffectFiles, StoredModel, answers, argument, flag, picture
from avahazard.cli.output import Shown, Whole, ask, emit, settings, table, warn
from avahazard.inference.model.choices import METHODS
from avahazard.notes import Note, counted
from avahazard.report import model_tables, sentences
from avahazard.report.tables import cell
from avahazard.results import calibration as results
from avahazard.results.base import Rows, plain
from avahazard.results.comparison import Comparison, Ladder, Prediction
from avahazard.results.diagnosis import LEVEL, Candidate, Diagnosis
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest


def show_calibration(model: results.Calibration) -> Iterator[Shown]:
    """Show what a calibration found."""
    yield Whole(f"{model.model}: {_parts(model)}")
    yield model_tables.parameters_table(model)
    yield from sentences.kinds_text(model.kinds) if model.kinds else ()
    yield model_tables.kinds_table(model)
    checks = model.diagnostics
    rhat = "infinite" if checks.rhat_max is None else f"{checks.rhat_max:.3f}"
    yield (
        f"{counted(model.n_events, 'event')}; {model.chains} chains of {model.draws} "
        f"draws, seed {model.seed}; {checks.acceptance:.0%} accepted."
    )
    yield (
        f"{'Converged' if checks.converged else 'Not converged'}: R-hat {rhat}, effective sample "
        f"size at least {round(checks.ess_min)}."
    )


def _parts(model: results.Calibration) -> str:
    """What a model is made of."""
    parts = [model.law + " law", model.method]
    if METHODS[model.method].knows_errors:
        parts.append(model.distribution)
    if model.scatter == "volume":
        parts.append("scatter by volume")
    if model.tails == "student":
        parts.append("Student's tails")
    if model.forward != "block":
        parts.append(f"runs of {model.forward}")
    if not model.centrifugal:
        parts.append("without centrifugal")
    if model.effects:
        parts.append("with " + ", ".join(model.effects))
    return ", ".join(parts)


@answers("calibrate.calibrate")
def calibrate(
    found: results.Calibration,
    name: Annotated[str, argument("A new name for the model.")],
    *,
    request: CalibrateRequest,
) -> Iterator[Shown]:
    """Calibrate a model on the records and store it.

    \b
    Examples:
      avahazard calibrate first
      avahazard calibrate voellmy --with turbulent-drag
      avahazard calibrate paper --method metropolis --path P01 --draws 10000
      avahazard calibrate here --path P01 --prior-from fit:P02,P03
      avahazard calibrate informed --prior a=0.5,0.05 --prior n=2e-6,1e-6
    """
    return show_calibration(found)


@answers("listing.show_models")
def models(found: Rows[results.ModelSummary]) -> Iterator[Shown]:
    """List the stored models.

    \b
    Example:
      avahazard models
    """
    if not found:
        yield "There are no models yet: make one with `avahazard calibrate NAME`."
        return
    rows = [
        (
            row.model,
            ", ".join(row.effects) or None,
            f"{row.law}, {row.method}",
            row.n_events,
            row.converged,
            row.created[:10],
        )
        for row in found
    ]
    columns = ("model", "effects", "law, method", ">events", "converged", "made")
    yield table("", columns, rows)


def _model(found: results.Calibration) -> Iterator[Shown]:
    yield from show_calibration(found)
    line = f"Stored {str(found.created).replace('T', ' ').removesuffix('Z')} (UTC)"
    parent = f", from {found.parent}" if found.parent else ""
    yield f"{line}{parent}, on the records {found.data_fingerprint[:12]}…."


def model(
    name: StoredModel,
    provenance: Annotated[
        bool, flag("--provenance", "Show what is needed to make it again.")
    ] = False,
) -> None:
    """Show a stored model: its posterior, and whether it converged.

    \b
    Examples:
      avahazard model first
      avahazard model first --provenance
    """
    if not provenance:
        emit(ask("calibrate.show_model", name=name), _model)
        return
    found = ask("calibrate.show_provenance", name=name)
    emit(found, _provenance)
    if found.records_changed:
        warn(Note("stale", model=name))


def _provenance(found: results.Provenance) -> Iterator[Shown]:
    made = found.made_with
    rows = [
        ("stored (UTC)", found.created),
        ("parent", found.parent),
        ("records", found.data_fingerprint),
        ("method", f"{found.method}, {found.chains} chains of {found.draws} draws"),
        ("seed", found.seed),
        ("paths", ", ".join(found.paths) or "all"),
        *((key, _specified(key, value)) for key, value in found.specification.items()),
        ("effect files, SHA-256", found.effect_sha256),
        ("lock, SHA-256", None if made is None else made.lock_sha256),
    ]
    yield table(f"Provenance of {found.model}", ("", "value"), rows)
    was = {} if made is None else made.versions
    versions = [(key, was.get(key), now) for key, now in found.now.versions.items()]
    yield table("", ("version of", "then", "now"), versions)


def _specified(key: str, value: Any) -> str | None:
    """A part of the specification; of priors, where they are from or their numbers."""
    if key == "prior":
        return value["source"] if value else None
    if key == "given":
        return ", ".join(f"{g['name']} {g['mean']:g} ± {g['sd']:g}" for g in value) or None
    return (", ".join(value) or None) if isinstance(value, list | tuple) else str(value)


@answers("calibrate.rerun")
def rerun(
    found: results.Rerun, name: StoredModel, effect_files: EffectFiles = None
) -> Iterator[Shown]:
    """Calibrate a stored model again, and say whether the result is identical.

    \b
    Example:
      avahazard rerun first
    """
    if found.identical:
        yield f"{found.model}: identical, every draw of {found.n_parameters} parameters."
        return
    rows = [(key, d.stored_mean, d.new_mean, d.largest) for key, d in found.differences.items()]
    columns = ("", ">stored mean", ">mean now", ">largest difference")
    yield table(f"{found.model}: not identical", columns, rows)


@answers("calibrate.add")
def add(
    found: results.Calibration,
    name: StoredModel,
    effects: Annotated[list[str], argument("Effects to add.", "EFFECT…")],
    new_name: Annotated[
        str, typer.Option("--as", metavar="NEW", help="Name of the new model.", show_default=False)
    ],
    effect_files: EffectFiles = None,
) -> Iterator[Shown]:
    """Add effects to a model: the child is calibrated, compared and stored.

    \b
    Examples:
      avahazard add first forest-drag --as forest
      avahazard add first my-effect --as mine --effect-file mine.py
    """
    yield from show_calibration(found)
    assert found.comparison is not None
    yield sentences.before_and_after_text(found.comparison)


@answers("effects.list_effects")
def effects(found: Rows[results.EffectEntry]) -> Iterator[Shown]:
    """List the effects that a model can have, and whether the present data can tell them.

    \b
    Example:
      avahazard effects
    """
    cells = [
        (row.key, row.needs, "yes" if row.lacking is None else f"no: {row.lacking}")
        for row in found
    ]
    yield table("Effects", ("effect", "needs", "supported by these data?"), cells)
    yield "More on one: avahazard effect KEY. Your own: avahazard effect new FILE."


def effect(
    context: typer.Context,
    key: Annotated[str, argument("An effect, or the word new.")],
    file: Annotated[Path | None, argument("With new: the effect file to write.")] = None,
) -> None:
    """Show the physics of one effect; `effect new FILE` writes a template for one's own.

    \b
    Examples:
      avahazard effect forest-drag
      avahazard effect new mine.py
    """
    if (key == "new") != (file is not None):
        raise typer.BadParameter("it is either KEY or new FILE", ctx=context, param_hint="KEY")
    if file is None:
        emit(ask("effects.show_effect", key=key), _effect)
        return
    written = ask("effects.write_effect_file", file=file)
    then = f"avahazard add MODEL KEY --as NEW --effect-file {written.file}"
    words = f"Written: {written.file}\nChange it, then: {then}"
    emit(written, lambda _: [Whole(words)])


def _effect(effect: results.EffectDetails) -> Iterator[Shown]:
    yield f"{effect.key}: {effect.meaning}"
    if effect.acts_on:
        yield f"It acts on: {effect.acts_on}."
    yield f"It needs: {effect.needs}."
    answer = "support it" if effect.lacking is None else f"do not support it: {effect.lacking}"
    yield f"These data {answer}."
    if effect.parameters:
        cells = [
            (
                p.name,
                p.unit,
                p.neutral,
                f"{cell(p.prior_mean)} ± {cell(p.prior_sd)}",
                _range(p.low, p.high),
            )
            for p in effect.parameters
        ]
        columns = ("parameter", "unit", ">neutral", ">prior", ">range")
        yield table("", columns, cells)


def _range(low: float | None, high: float | None) -> str:
    if low is None and high is None:
        return "any"
    least, most = ("" if end is None else cell(end) for end in (low, high))
    return f"{least} to {most}"


def _notes(found: Comparison) -> Iterator[str]:
    yield from found.notes
    unsure = found.scores.pareto_k_bad - found.scores.pareto_k_refitted
    if unsure > 0:
        weigh = "record weighs" if unsure == 1 else "records weigh"
        yield f"{unsure} {weigh} so much that the left-out density is rough (Pareto k > 0.7)."


@answers("compare.compare", notes=_notes)
def compare(
    found: Comparison,
    name: StoredModel,
    plot: Annotated[Path | None, picture("Draw where it fails")] = None,
    effect_files: EffectFiles = None,
) -> Iterator[Shown]:
    """Set a model against the measurements: its scores, and where it fails.

    \b
    Examples:
      avahazard compare first
      avahazard compare first --plot where.png
    """
    scores = found.scores
    yield model_tables.scores_table(found.coordinate, model_tables.compared_parts(found))
    yield from sentences.error_text(found)
    if scores.elpd_loo is not None:
        se = "" if scores.elpd_loo_se is None else f" ± {scores.elpd_loo_se:.1f}"
        yield (
            "elpd (log predictive density, each record left out in turn): "
            f"{scores.elpd_loo:.1f}{se} nats (natural logarithm); higher is better."
        )
    yield model_tables.budget_table(found)
    yield model_tables.misfit_table(found)
    yield model_tables.failures_table(found)
    yield sentences.failure_text(found)


ALONE, NEAR = 0.05, 0.1
CANDIDATES_SHOWN = 8
FORCE_OFF = 4
"""Standard errors off the measured force from which on a fitted one is doubted."""


@answers("diagnose.diagnose_model")
def diagnose(found: Diagnosis, name: StoredModel, *, request: DiagnoseRequest) -> Iterator[Shown]:
    """Ask which effect a model lacks, if any; what to measure next.

    \b
    Examples:
      avahazard diagnose first
      avahazard diagnose first --expect snow-type
      avahazard diagnose first --plot candidates.png
      avahazard diagnose first --write-effect law.py
    """
    yield sentences.verdict_text(found, found.model)
    if found.declared is not None:
        words = ", ".join(found.declared.effects)
        yield f"Declared beforehand ({found.declared.at}), tested first: {words}."
    candidates = model_tables.candidates_table(found)
    yield replace(candidates, shown=max(candidates.shown or 0, CANDIDATES_SHOWN))
    best = found.candidates[0] if found.candidates else None
    for c in found.candidates:
        if c.effect in found.named:
            yield c.physics if len(found.named) == 1 else f"{c.effect}: {c.physics}"
    yield model_tables.shape_table(found)
    yield model_tables.laws_table(found)
    if found.effect_file is not None:
        yield Whole(f"Written: {found.effect_file}")
    elif found.lawful is not None:
        words = f"avahazard diagnose {shlex.quote(found.model)} --write-effect FILE"
        yield Whole(f"The first as an effect file: {words}")
    if found.verdict == "adequate" and best is not None:
        yield from _nearest(best, len(found.candidates))
    yield from _findings(found)
    # Where an effect is named it is added first; what parts it from others comes after.
    if found.verdict != "missing-effect" or settings().verbose:
        yield model_tables.measure_table(found)


def _nearest(best: Candidate, n_tried: int) -> Iterator[Shown]:
    """A candidate that would count had it been the only question."""
    if best.p_value_alone < ALONE and LEVEL < best.p_value < NEAR:
        alone = "< 0.001" if best.p_value_alone < 0.001 else f"= {best.p_value_alone:.3f}"
        yield (
            f"{best.effect} comes nearest: p {alone} by itself, "
            f"{best.p_value:.2f} as the best of {n_tried}. The first counts only where it was "
            "declared beforehand (--expect)."
        )


def _findings(found: Diagnosis) -> Iterator[Shown]:
    """What else was found, beside the candidates, as what the measured force says of them."""
    for c in found.candidates[:CANDIDATES_SHOWN]:
        if c.force_witness is not None and c.shape is None:  # a curve is no one amount
            value, se = c.force_witness.value, c.force_witness.se
            name, fitted = next(iter(c.parameters.items()))
            off = abs(fitted - value) > FORCE_OFF * se
            rest = f", over {FORCE_OFF} sd off: another form of it may act" if off else ""
            yield (
                f"By the measured force {name} is {value:.2g} ± {se:.2g} "
                f"(fitted: {fitted:.2g}{rest})."
            )
    if found.impossible_stops:
        n = len(found.impossible_stops)
        yield (
            f"{n} recorded {'stop' if n == 1 else 'stops'} on ground too steep for a block to stop "
            f"there: {', '.join(found.impossible_stops[:6])}{', …' if n > 6 else ''}."
        )
    if found.heavy_tails:
        yield (
            "Friction scatters with heavy tails: Student's t was used. Look at wrong records: "
            f"{', '.join(found.suspect_events[:6]) or 'none stands out'}."
        )
    for effect, loss in found.still_needed.items():
        need = "is still needed" if loss > 0 else "is no longer needed"
        yield f"{effect} {need} (evidence {loss:+.1f} nats)."


EXTRA = {"noise_floor_m", "noise_floor_crps_m"}
"""Of the steps of the ladder, what the table alone shows."""


@answers(
    "compare.ladder",
    document=lambda found: [
        {key: value for key, value in row.items() if key not in EXTRA} for row in plain(found.rows)
    ],
)
def ladder(
    found: Ladder,
    plot: Annotated[Path | None, picture("Draw the held-out error and the error budgets")] = None,
) -> Iterator[Shown]:
    """List every model and its error, oldest first.

    \b
    Examples:
      avahazard ladder
      avahazard ladder --plot ladder.png
    """
    yield model_tables.ladder_table(found.rows)
    # Errors by other held-out groups than those of the parent.
    notes = (note for row in found.rows for note in row.notes)
    yield from (str(note) for note in notes if note.key == "held_out_by_event")


@answers(
    "compare.predict",
    # Elevations, unless `coordinate` of a row says otherwise (docs/results.md).
    document=lambda found: (
        found.events if found.scores is None else {"events": found.events, "scores": found.scores}
    ),
)
def predict(
    found: Prediction,
    name: StoredModel,
    file: Annotated[Path, argument("Events.", "EVENTS.csv")],
    effect_files: EffectFiles = None,
) -> Iterator[Shown]:
    """Predict the runout of each event of a file; its own runout only serves for scores.

    \b
    Example:
      avahazard predict first new-events.csv
    """
    yield model_tables.predicted_table(found.events)
    if found.scores is not None:
        scores = [("these events", found.scores)]
        yield model_tables.scores_table(found.scores.coordinate, scores)
