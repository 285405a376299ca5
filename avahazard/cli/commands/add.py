"""`avahazard add`."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.comparison_table import fall_of_error
from avahazard.cli.model_table import show_calibration
from avahazard.cli.options import EffectFiles, StoredModel
from avahazard.cli.output import emit, warn
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings


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
    warn(*found.notes)
