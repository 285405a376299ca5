"""The program `avahazard`: its commands and the options of all of them.

A command is a function in a file under `commands`; it is loaded only when it is called, so
that help is there at once. To add one, add its line to COMMANDS.
"""

from __future__ import annotations

import os
from typing import Annotated

import typer

from avahazard import __version__
from avahazard.cli.commands_group import CommandsGroup, Entry
from avahazard.cli.settings import CliSettings

# Name, module under avahazard.cli.commands, and the first line of its help.
COMMANDS: tuple[Entry, ...] = (
    Entry("run", "run", "Run a whole project: only what is out of date is done."),
    Entry("init", "init", "Create the database."),
    Entry("db", "db", "Upgrade, look at, check or copy the database."),
    Entry(
        "import",
        "import_files",
        "Import tables, or folders of them, or paths drawn as lines on a terrain model.",
    ),
    Entry("paths", "paths", "List the paths."),
    Entry("path", "path", "Show how the profile of a path was smoothed, and check it."),
    Entry(
        "runout",
        "runout",
        "Run the block once: its stop and its speeds; or F(μ), where it stops under any friction.",
    ),
    Entry("friction", "friction", "Show the apparent friction of the events and its density."),
    Entry("fit", "fit", "Fit laws of friction against volume by least squares."),
    Entry("calibrate", "calibrate", "Calibrate a model on the records and store it."),
    Entry("models", "models", "List the stored models."),
    Entry("model", "model", "Show a stored model: its posterior, and whether it converged."),
    Entry(
        "rerun", "rerun", "Calibrate a stored model again, and say whether the result is identical."
    ),
    Entry(
        "compare",
        "compare",
        "Set a model against the measurements: its scores, and where it fails.",
    ),
    Entry("diagnose", "diagnose", "Ask which effect a model lacks, if any; what to measure next."),
    Entry(
        "effects",
        "effects",
        "List the effects that a model can have, and whether the present data can tell them.",
    ),
    Entry(
        "effect",
        "effect",
        "Show the physics of one effect; `effect new FILE` writes a template for one's own.",
    ),
    Entry("add", "add", "Add effects to a model: the child is calibrated, compared and stored."),
    Entry("ladder", "ladder", "List every model and its error, oldest first."),
    Entry(
        "predict",
        "predict",
        "Predict the runout of each event of a file; its own runout only serves for scores.",
    ),
    Entry(
        "volumes",
        "volumes",
        "Fit how often which volumes come down the paths: return levels and their error.",
    ),
    Entry(
        "hazard",
        "hazard",
        "Give the design runout of return periods, and the runout of volumes, path by path.",
    ),
    Entry(
        "zones", "zones", "Find speed, pressure and hazard zones along the paths, by return period."
    ),
    Entry(
        "alpha-beta",
        "alpha_beta",
        "Give the alpha-beta runout of the paths: a baseline from the terrain alone.",
    ),
    Entry("report", "report", "Write a report of a model as one HTML file that needs no network."),
    Entry(
        "paper-figures",
        "paper_figures",
        "Draw every figure of Ancey (2005) from the records and stored models.",
    ),
    Entry("export", "export", "Write the bounds and zones of a model for a GIS or a spreadsheet."),
    Entry(
        "demo",
        "demo",
        "Do the main job on the bundled data, a twin of the paper's seven paths; "
        "find what is hidden.",
    ),
    Entry("synth", "synth", "Make a world with known hidden effects, to try the program on."),
)


class Commands(CommandsGroup):
    """The commands of `avahazard`."""

    entries = COMMANDS


app = typer.Typer(
    cls=Commands,
    # Plain help: loading the decorated one takes longer than all the rest.
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def show_version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        typer.echo(f"avahazard {__version__}")
        raise typer.Exit


@app.callback()
def options(
    context: typer.Context,
    db: Annotated[
        str,
        typer.Option(
            metavar="URL",
            envvar="AVAHAZARD_DB",
            help="The database: a file path or an SQLAlchemy URL.",
        ),
    ] = "avahazard.db",
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document on standard output.")
    ] = False,
    _version: Annotated[
        bool,
        typer.Option("--version", help="Print the version.", callback=show_version, is_eager=True),
    ] = False,
) -> None:
    """Calibrate avalanche friction on recorded events, find what the model misses, draw bounds."""
    context.obj = CliSettings(database=db, as_json=as_json)


def main() -> None:
    """Run the program."""
    # Our own threads and processes share the work. Those of linear algebra would wait for each
    # other at every step of a fit, whose matrices are small: several times its own work.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    app(prog_name="avahazard")
