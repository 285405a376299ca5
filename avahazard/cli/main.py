"""The program `avahazard`: its commands and the options of all of them.

A command is a function in a file beside this one; it is loaded only when it is called, so that
help is there at once. To add one, add its name to COMMANDS.
"""

import ast
import io
import keyword
import os
import sys
from functools import cache
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from avahazard import __version__
from avahazard.records.errors import AvahazardError, did_you_mean, interruptible

COMMANDS = {
    name: module
    for module, names in (
        ("project", "run"),
        ("files", "init db"),
        ("records", "import paths path runout friction fit"),
        (
            "models",
            "calibrate models model rerun compare diagnose effects effect add ladder predict",
        ),
        ("hazard", "volumes hazard zones simulate map"),
        ("records", "alpha-beta"),
        ("files", "report export"),
        ("project", "demo"),
        ("files", "synth"),
    )
    for name in names.split()
}
"""The module under `avahazard.cli` of each command."""
COMPUTING = frozenset(
    "calibrate compare diagnose add ladder hazard zones simulate map report demo".split()  # noqa: SIM905
)
"""Commands that compute for long, with the options of the engine."""

AFTER = dict.fromkeys(("import", "calibrate", "compare", "diagnose", "add"), "Nothing was stored.")
AFTER |= dict.fromkeys(
    ("run", "hazard", "zones", "simulate"), "The same command goes on with what is not stored yet."
)
"""What an interruption of a command leaves."""


def function_of(command: str) -> str:
    """Its function; a name that Python keeps for itself ends in an underscore."""
    name = command.replace("-", "_")
    return f"{name}_" if keyword.iskeyword(name) else name


def help_of(command: str) -> str:
    """The first line of its help, read without loading the module."""
    return _helps(COMMANDS[command])[function_of(command)]


@cache
def _helps(module: str) -> dict[str, str]:
    """By name, the first line of the help of each function of a module, and of each group."""
    found = {}
    source = Path(__file__).with_name(f"{module}.py").read_text(encoding="utf-8")
    for node in ast.parse(source).body:
        if isinstance(node, ast.FunctionDef):
            found[node.name] = (ast.get_docstring(node) or "").partition("\n")[0]
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Call):
            given = {k.arg: k.value for k in node.value.keywords}
            if "help" in given:
                found[ast.unparse(node.targets[0])] = ast.literal_eval(given["help"])
    return found


class Commands(TyperGroup):
    """The commands of `avahazard`, loaded when they are called; an error is one message."""

    def list_commands(self, _ctx: Any) -> list[str]:
        """Return the names, without loading the commands."""
        return list(COMMANDS)

    def get_command(self, _ctx: Any, cmd_name: str) -> Any:
        """Load one command; None when there is none of this name."""
        return load(cmd_name) if cmd_name in COMMANDS else None

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        """Take the options that all commands have from wherever they stand."""
        first, rest, left = list[str](), list[str](), iter(args)
        for word in left:
            if word == "--":
                rest += [word, *left]
            elif word == "--db":
                first += [word, *islice(left, 1)]
            else:
                common = word in ("--json", "--verbose") or word.startswith("--db=")
                (first if common else rest).append(word)
        return super().parse_args(ctx, [*first, *rest])

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command that is called; of an unknown one, say which are close."""
        if args[0] not in COMMANDS and not args[0].startswith("-"):
            close = did_you_mean(args[0], COMMANDS)
            ctx.fail(f"No such command '{args[0]}'. {close}".rstrip())
        return super().resolve_command(ctx, args)

    def format_commands(self, _ctx: Any, formatter: Any) -> None:
        """Write the list of commands for the help, without loading them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, help_of(name)) for name in COMMANDS])

    def invoke(self, ctx: Any) -> Any:
        """Run the command; an error that the user can correct ends with status 1."""
        try:
            with interruptible():
                return super().invoke(ctx)
        except BrokenPipeError:
            raise
        except KeyboardInterrupt:
            left = AFTER.get(ctx.invoked_subcommand or "", "")
            typer.echo(f"\nInterrupted. {left}".rstrip(), err=True)
            raise
        except (AvahazardError, OSError) as error:
            from avahazard.cli.output import show_error  # noqa: PLC0415

            show_error(error)
            raise typer.Exit(1) from error


def load(name: str) -> Any:
    """Return the command of this name: its function, or its group."""
    from avahazard.cli.options import taking_requests, with_engine  # noqa: PLC0415

    found = getattr(import_module(f"avahazard.cli.{COMMANDS[name]}"), function_of(name))
    if isinstance(found, typer.Typer):
        command = get_command(found)
    else:
        single = typer.Typer(rich_markup_mode=None, add_completion=False)
        whole = with_engine(found) if name in COMPUTING else found
        single.command(name)(taking_requests(whole))
        command = get_command(single)
    command.name = name
    return command


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
    from avahazard.cli.output import CliSettings, settings_of_command  # noqa: PLC0415 (slow)

    source = context.get_parameter_source("db")
    named = source is not None and source.name == "COMMANDLINE"
    before = settings_of_command.set(CliSettings(db, as_json, verbose, named))
    context.call_on_close(lambda: settings_of_command.reset(before))


def main() -> None:
    """Run the program."""
    # Our own threads and processes share the work. Those of linear algebra would wait for each
    # other at every step of a fit, whose matrices are small: several times its own work.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # none where it is closed
            stream.reconfigure(errors="replace")  # letters that its encoding has not
    app(prog_name="avahazard")
