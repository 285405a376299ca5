"""The program `avahazard`: its commands and the options of all of them.

A command is a function in a file beside this one; it is loaded only when it is called, so that
help is there at once. To add one, add its line to COMMANDS.
"""

from __future__ import annotations

import keyword
import os
from importlib import import_module
from typing import Annotated, Any, NamedTuple

import typer
from typer.core import TyperGroup
from typer.main import get_command

from avahazard import __version__
from avahazard.records.errors import AvahazardError, did_you_mean


class Entry(NamedTuple):
    """A command: its name, its module under `avahazard.cli`, and the first line of its help."""

    name: str
    module: str
    help: str


class Commands(TyperGroup):
    """The commands of `avahazard`, loaded when they are called; an error is one message."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names, without loading the commands."""
        del ctx
        return [entry.name for entry in COMMANDS]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Load one command; None when there is none of this name."""
        del ctx
        for entry in COMMANDS:
            if entry.name == cmd_name:
                return load(entry)
        return None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command that is called; of an unknown one, say which are close."""
        if self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            close = did_you_mean(args[0], self.list_commands(ctx))
            ctx.fail(f"No such command '{args[0]}'. {close}".rstrip())
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands for the help, without loading them."""
        del ctx
        with formatter.section("Commands"):
            formatter.write_dl([(entry.name, entry.help) for entry in COMMANDS])

    def invoke(self, ctx: Any) -> Any:
        """Run the command; an error that the user can mend ends with status 1."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            raise
        except (AvahazardError, OSError) as error:
            from avahazard.cli.output import show_error  # noqa: PLC0415

            show_error(error)
            raise typer.Exit(1) from error


def load(entry: Entry) -> Any:
    """Return the command of `entry`: the function, or the group, that bears its name.

    A name that Python keeps for itself, such as import, has an underscore after it.
    """
    from avahazard.cli.options import add_engine_options, taking_requests  # noqa: PLC0415

    module = import_module(f"avahazard.cli.{entry.module}")
    name = entry.name.replace("-", "_")
    found = getattr(module, f"{name}_" if keyword.iskeyword(name) else name)
    if isinstance(found, typer.Typer):
        command = get_command(found)
    else:
        single = typer.Typer(rich_markup_mode=None, add_completion=False)
        single.command(entry.name)(taking_requests(found))
        command = get_command(single)
    command.name = entry.name
    if entry.name in COMPUTING:
        add_engine_options(command)
    return command


COMPUTING = frozenset(
    ("calibrate", "compare", "diagnose", "add", "ladder", "hazard", "zones", "report", "demo")
)
"""Commands that compute for long, with the options of the engine."""
COMMANDS: tuple[Entry, ...] = (
    Entry("run", "project", "Run a whole project: only what is out of date is done."),
    Entry("init", "files", "Create the database."),
    Entry("db", "files", "Upgrade, look at, check or copy the database."),
    Entry(
        "import",
        "records",
        "Import tables, or folders of them, or paths drawn as lines on a terrain model.",
    ),
    Entry("paths", "records", "List the paths."),
    Entry("path", "records", "Show how the profile of a path was smoothed, and check it."),
    Entry(
        "runout",
        "records",
        "Run the block once: its stop and its speeds; or F(μ), where it stops under any friction.",
    ),
    Entry("friction", "records", "Show the apparent friction of the events and its density."),
    Entry("fit", "records", "Fit laws of friction against volume by least squares."),
    Entry("calibrate", "models", "Calibrate a model on the records and store it."),
    Entry("models", "models", "List the stored models."),
    Entry("model", "models", "Show a stored model: its posterior, and whether it converged."),
    Entry(
        "rerun",
        "models",
        "Calibrate a stored model again, and say whether the result is identical.",
    ),
    Entry(
        "compare",
        "criticism",
        "Set a model against the measurements: its scores, and where it fails.",
    ),
    Entry("diagnose", "criticism", "Ask which effect a model lacks, if any; what to measure next."),
    Entry(
        "effects",
        "models",
        "List the effects that a model can have, and whether the present data can tell them.",
    ),
    Entry(
        "effect",
        "models",
        "Show the physics of one effect; `effect new FILE` writes a template for one's own.",
    ),
    Entry("add", "models", "Add effects to a model: the child is calibrated, compared and stored."),
    Entry("ladder", "criticism", "List every model and its error, oldest first."),
    Entry(
        "predict",
        "criticism",
        "Predict the runout of each event of a file; its own runout only serves for scores.",
    ),
    Entry(
        "volumes",
        "hazard",
        "Fit how often which volumes come down the paths: return levels and their error.",
    ),
    Entry(
        "hazard",
        "hazard",
        "Give the design runout of return periods, and the runout of volumes, path by path.",
    ),
    Entry(
        "zones",
        "hazard",
        "Find speed, pressure and hazard zones along the paths, by return period.",
    ),
    Entry(
        "alpha-beta",
        "records",
        "Give the alpha-beta runout of the paths: a baseline from the terrain alone.",
    ),
    Entry("report", "files", "Write a report of a model as one HTML file that needs no network."),
    Entry(
        "paper-figures",
        "files",
        "Draw every figure of Ancey (2005) from the records and stored models.",
    ),
    Entry("export", "files", "Write the bounds and zones of a model for a GIS or a spreadsheet."),
    Entry(
        "demo",
        "project",
        "Do the main job on the bundled data, a twin of the paper's seven paths; "
        "find what is hidden.",
    ),
    Entry("synth", "files", "Make a synthetic dataset with known hidden effects."),
)


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
    verbose: Annotated[
        bool, typer.Option("--verbose", help="Print every table, and every note by itself.")
    ] = False,
    _version: Annotated[
        bool,
        typer.Option("--version", help="Print the version.", callback=show_version, is_eager=True),
    ] = False,
) -> None:
    """Calibrate avalanche friction on recorded events, find what the model misses, draw bounds."""
    from avahazard.cli.output import CliSettings  # noqa: PLC0415 (help needs no tables)

    context.obj = CliSettings(db, as_json, verbose)


def main() -> None:
    """Run the program."""
    # Our own threads and processes share the work. Those of linear algebra would wait for each
    # other at every step of a fit, whose matrices are small: several times its own work.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    app(prog_name="avahazard")
