"""Commands that are loaded when they are called, and whose errors are one message."""

from __future__ import annotations

import keyword
from collections.abc import Sequence
from importlib import import_module
from typing import Any, ClassVar, NamedTuple

import typer
from typer.core import TyperGroup
from typer.main import get_command

from avahazard.cli.engine_options import COMMANDS as WORKING
from avahazard.cli.engine_options import add_engine_options
from avahazard.records.errors import AvahazardError


class Entry(NamedTuple):
    """A command: its name, its module under `avahazard.cli.commands`, one line of help."""

    name: str
    module: str
    help: str


class CommandsGroup(TyperGroup):
    """A group whose commands stand in `entries`."""

    entries: ClassVar[Sequence[Entry]] = ()

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names, without loading the commands."""
        del ctx
        return [entry.name for entry in self.entries]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Load one command; None when there is none of this name."""
        del ctx
        for entry in self.entries:
            if entry.name == cmd_name:
                return load(entry)
        return None

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands for the help, without loading them."""
        del ctx
        with formatter.section("Commands"):
            formatter.write_dl([(entry.name, entry.help) for entry in self.entries])

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
    module = import_module(f"avahazard.cli.commands.{entry.module}")
    name = entry.name.replace("-", "_")
    found = getattr(module, f"{name}_" if keyword.iskeyword(name) else name)
    if isinstance(found, typer.Typer):
        command = get_command(found)
    else:
        single = typer.Typer(rich_markup_mode=None, add_completion=False)
        single.command(entry.name)(found)
        command = get_command(single)
    command.name = entry.name
    if entry.name in WORKING:
        add_engine_options(command)
    return command
