"""`avahazard add`."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.comparison_table import error_words, unit_words
from avahazard.cli.model_table import show_calibration
from avahazard.cli.options import EffectFiles, StoredModel
from avahazard.cli.output import emit, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings
from avahazard.results.ladder import BeforeAndAfter


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
    from avahazard.workflow.add import add as run  # noqa: PLC0415

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
        console.print(fall_of_error(found.comparison), soft_wrap=True)

    emit(context, found, render)
    for note in found.notes:
        warn(note)


def fall_of_error(found: BeforeAndAfter) -> str:
    """How far the error fell: that of `compare`, on what was held out."""
    by = "paths" if found.held_out_by == "path" else "folds"
    what = f"Error (CRPS in {unit_words(found.coordinate)}, {by} held out)"
    after = found.after.held_out_crps_m
    if found.before is None:
        return f"{what}: {after:.1f} m. {error_words(found)}"
    before = found.before.held_out_crps_m
    text = f"{what} {_change(before, after)}"
    if found.fall is not None:
        text += f" (by {found.fall.q05_m:.1f} to {found.fall.q95_m:.1f} m with 90 % confidence)"
    x = (found.before.held_out_crps_x_m, found.after.held_out_crps_x_m)
    if found.coordinate != "x" and x[0] is not None and x[1] is not None:
        text += f"; in x it {_change(x[0], x[1])}"
    return f"{text}. {error_words(found)}"


def _change(before: float, after: float) -> str:
    verb = "fell" if after < before else "rose"
    return f"{verb} from {before:.1f} to {after:.1f} m ({(after - before) / before:+.1%})"
