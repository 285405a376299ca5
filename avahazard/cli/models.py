"""Commands on models: calibrate, models, model, rerun, add, effects, effect."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from avahazard.cli.options import EffectFiles, StoredModel
from avahazard.cli.output import emit, settings, show, table, warn
from avahazard.inference.model.choices import METHODS
from avahazard.inference.model.specification import GIVEN
from avahazard.notes import counted
from avahazard.progress import show_progress
from avahazard.report.language import TERMINAL
from avahazard.report.model_tables import kinds_table, parameters_table
from avahazard.report.sentences import before_and_after_words, kinds_words
from avahazard.report.tables import cell
from avahazard.results.calibration import Calibration
from avahazard.results.models import EffectDetails
from avahazard.workflow.requests import CalibrateRequest


def calibrate(
    context: typer.Context,
    name: Annotated[str, typer.Argument(help="A new name for the model.", show_default=False)],
    *,
    request: CalibrateRequest,
) -> None:
    """Calibrate a model on the records and store it.

    \b
    Examples:
      avahazard calibrate first
      avahazard calibrate voellmy --with turbulent-drag
      avahazard calibrate paper --method metropolis --path P01 --draws 10000
      avahazard calibrate here --path P01 --prior-from elsewhere
      avahazard calibrate informed --prior a=0.5,0.05 --prior n=2e-6,1e-6
    """
    from avahazard.workflow.calibrate import calibrate as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(settings(context).database, name, request, report)
    emit(context, found, lambda console: show_calibration(console, found))
    warn(*found.notes)


def show_calibration(console: Console, model: Calibration, *, verbose: bool = False) -> None:
    """Print what a calibration found."""
    console.print(f"{model.model}: {_parts(model)}", soft_wrap=True)
    show(console, parameters_table(model, TERMINAL))
    for words in [] if model.kinds is None else kinds_words(model.kinds, TERMINAL):
        console.print(words, soft_wrap=True)
    show(console, kinds_table(model, TERMINAL), verbose=verbose)
    given = model.given_priors or {}
    if given:
        each = (f"{key} {p.mean:g} ± {p.sd:g} {p.unit}".rstrip() for key, p in given.items())
        console.print(f"Priors as given: {', '.join(each)}.")
    checks = model.diagnostics
    rhat = "infinite" if checks.rhat_max is None else f"{checks.rhat_max:.3f}"
    console.print(
        f"{counted(model.n_events, 'event')}; {model.chains} chains of {model.draws} "
        f"draws, seed {model.seed}; {checks.acceptance:.0%} accepted."
    )
    console.print(
        f"{'Converged' if checks.converged else 'Not converged'}: R-hat {rhat}, effective sample "
        f"size at least {round(checks.ess_min)}."
    )


def _parts(model: Calibration) -> str:
    """What a model is made of."""
    parts = [model.law + " law", model.method]
    if METHODS[model.method].knows_errors:
        parts.append(model.distribution)
    if model.scatter == "volume":
        parts.append("scatter by volume")
    if model.tails == "student":
        parts.append("Student's tails")
    if not model.centrifugal:
        parts.append("without centrifugal")
    if model.effects:
        parts.append("with " + ", ".join(model.effects))
    if model.prior is not None and not model.prior.source.startswith(GIVEN):
        parts.append(f"prior from {model.prior.source}")
    return ", ".join(parts)


def models(context: typer.Context) -> None:
    """List the stored models.

    \b
    Example:
      avahazard models
    """
    from avahazard.workflow.models import show_models  # noqa: PLC0415

    found = show_models(settings(context).database)

    def render(console: Console) -> None:
        if not found:
            console.print("There are no models yet: make one with `avahazard calibrate NAME`.")
            return
        rows = [
            (
                row.model if row.parent is None else f"{row.model} (from {row.parent})",
                row.law,
                ", ".join(row.effects) or None,
                row.method,
                row.n_events,
                row.converged,
                row.created[:10],
            )
            for row in found
        ]
        columns = ("model", "law", "effects", "method", ">events", "converged", "made")
        console.print(table("", columns, rows))

    emit(context, found, render)


def model(
    context: typer.Context,
    name: Annotated[str, typer.Argument(help="The name of a model.", show_default=False)],
    provenance: Annotated[
        bool, typer.Option("--provenance", help="Show what is needed to make it again.")
    ] = False,
) -> None:
    """Show a stored model: its posterior, and whether it converged.

    \b
    Examples:
      avahazard model first
      avahazard model first --provenance
    """
    if provenance:
        _show_provenance(context, name)
        return
    from avahazard.workflow.models import show_model  # noqa: PLC0415

    found = show_model(settings(context).database, name)

    def render(console: Console) -> None:
        show_calibration(console, found, verbose=settings(context).verbose)
        line = f"Stored {str(found.created).replace('T', ' ').removesuffix('Z')} (UTC)"
        parent = f", from {found.parent}" if found.parent else ""
        fingerprint = found.data_fingerprint[:12]
        console.print(f"{line}{parent}, on the records {fingerprint}….")

    emit(context, found, render)
    warn(*found.notes)


def _show_provenance(context: typer.Context, name: str) -> None:
    from avahazard.workflow.models import show_provenance  # noqa: PLC0415

    found = show_provenance(settings(context).database, name)
    made = found.made_with

    def render(console: Console) -> None:
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
        console.print(table(f"Provenance of {name}", ("", "value"), rows))
        was = {} if made is None else made.versions
        versions = [(key, was.get(key), now) for key, now in found.now.versions.items()]
        console.print(table("", ("version of", "then", "now"), versions))

    emit(context, found, render)
    if found.records_changed:
        warn(f"the records have changed since {name} was calibrated.")


def _specified(key: str, value: Any) -> str | None:
    """A part of the specification; of priors, where they are from or their numbers."""
    if key == "prior":
        return value["source"] if value else None
    if key == "given":
        return ", ".join(f"{g['name']} {g['mean']:g} ± {g['sd']:g}" for g in value) or None
    return (", ".join(value) or None) if isinstance(value, list | tuple) else str(value)


def rerun(context: typer.Context, name: StoredModel, effect_file: EffectFiles = None) -> None:
    """Calibrate a stored model again, and say whether the result is identical.

    \b
    Example:
      avahazard rerun first
    """
    from avahazard.workflow.models import rerun as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(settings(context).database, name, effect_files=effect_file or (), report=report)

    def render(console: Console) -> None:
        if found.identical:
            console.print(f"{name}: identical, every draw of {found.n_parameters} parameters.")
            return
        rows = [(key, d.stored_mean, d.new_mean, d.largest) for key, d in found.differences.items()]
        columns = ("", ">stored mean", ">mean now", ">largest difference")
        console.print(table(f"{name}: not identical", columns, rows))

    emit(context, found, render)
    warn(*found.notes)


def add(
    context: typer.Context,
    name: StoredModel,
    effect: Annotated[
        list[str], typer.Argument(metavar="EFFECT…", help="Effects to add.", show_default=False)
    ],
    as_: Annotated[
        str, typer.Option("--as", metavar="NEW", help="Name of the new model.", show_default=False)
    ],
    effect_file: EffectFiles = None,
) -> None:
    """Add effects to a model: the child is calibrated, compared and stored.

    \b
    Examples:
      avahazard add first forest-drag --as forest
      avahazard add first my-effect --as mine --effect-file mine.py
    """
    from avahazard.workflow.calibrate import add as run  # noqa: PLC0415

    with show_progress() as report:
        found = run(
            settings(context).database,
            name,
            effect,
            as_,
            effect_files=effect_file or (),
            report=report,
        )

    def render(console: Console) -> None:
        show_calibration(console, found)
        assert found.comparison is not None
        console.print(before_and_after_words(found.comparison, TERMINAL), soft_wrap=True)

    emit(context, found, render)
    warn(*found.notes)


def effects(context: typer.Context) -> None:
    """List the effects that a model can have, and whether the present data can tell them.

    \b
    Example:
      avahazard effects
    """
    from avahazard.workflow.effects import list_effects  # noqa: PLC0415

    found = list_effects(settings(context).database)

    def render(console: Console) -> None:
        cells = [
            (row.key, row.needs, "yes" if row.lacking is None else f"no: {row.lacking}")
            for row in found
        ]
        columns = ("effect", "needs", "can these data tell?")
        console.print(table("Effects", columns, cells))
        console.print("More on one: avahazard effect KEY. Your own: avahazard effect new FILE.")

    emit(context, found, render)


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
        then = f"avahazard add MODEL KEY --as NEW --effect-file {written.file}"
        emit(context, written, f"Written: {written.file}\nChange it, then: {then}")
        return
    found = show_effect(settings(context).database, key)
    emit(context, found, lambda console: _render_effect(console, found))


def _render_effect(console: Console, effect: EffectDetails) -> None:
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
                f"{cell(p.prior_mean, TERMINAL)} ± {cell(p.prior_sd, TERMINAL)}",
                _range(p.low, p.high),
            )
            for p in effect.parameters
        ]
        columns = ("parameter", "unit", ">neutral", ">prior", ">range")
        console.print(table("", columns, cells))


def _range(low: float | None, high: float | None) -> str:
    if low is None and high is None:
        return "any"
    least, most = ("" if end is None else cell(end, TERMINAL) for end in (low, high))
    return f"{least} to {most}"
