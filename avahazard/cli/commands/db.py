"""`avahazard db upgrade`, `status`, `check` and `backup`."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console

from avahazard.cli.output import emit, table
from avahazard.cli.progress import show_progress
from avahazard.cli.settings import settings

db = typer.Typer(
    help="Upgrade, look at, check or copy the database.",
    rich_markup_mode=None,
    add_completion=False,
    no_args_is_help=True,
)


@db.command()
def upgrade(context: typer.Context) -> None:
    """Bring the tables of the database up to date.

    \b
    Example:
      avahazard db upgrade
    """
    from avahazard.workflow.database import upgrade_database  # noqa: PLC0415

    found = upgrade_database(settings(context).database)

    def render(console: Console) -> None:
        if found.backup is not None:
            console.print(f"Copied it to {found.backup} before.", soft_wrap=True)
        if found.from_ == found.to:
            console.print(f"The database {found.database} is up to date.", soft_wrap=True)
        else:
            console.print(
                f"The database {found.database} went from revision {found.from_} to {found.to}.",
                soft_wrap=True,
            )

    emit(context, found, render)


@db.command()
def status(context: typer.Context) -> None:
    """Show the revision of the database and what it holds.

    \b
    Examples:
      avahazard db status
      avahazard --db valley.db db status
    """
    from avahazard.workflow.database import database_status  # noqa: PLC0415

    found = database_status(settings(context).database)

    def render(console: Console) -> None:
        console.print(f"Database: {found.database}", soft_wrap=True)
        console.print(
            f"Tables: {found.state} (revision {found.revision or 'none'}, "
            f"this program's is {found.head})"
        )
        if found.counts:
            console.print(table("", ("holds", ">number"), found.counts.items()))

    emit(context, found, render)


@db.command()
def check(
    context: typer.Context,
    full: Annotated[
        bool, typer.Option("--full", help="Calibrate some models again: the same draws?")
    ] = False,
) -> None:
    """Check that the database is whole, by its checksums; status 1 when it is not.

    \b
    Examples:
      avahazard db check
      avahazard db check --full
    """
    from avahazard.records.errors import AvahazardError  # noqa: PLC0415
    from avahazard.workflow.database import check as check_whole  # noqa: PLC0415

    with show_progress() as report:
        found = check_whole(settings(context).database, full=full, report=report)
    if not found.whole:
        faults = "\n".join(found.problems)
        raise AvahazardError(
            f"The database {found.database} is not whole.\n{faults}", "Go back to a backup."
        )

    def render(console: Console) -> None:
        console.print(f"The database {found.database} is whole.", soft_wrap=True)
        for model in found.recomputed or ():
            words = "as stored, to the last bit"
            if not model.identical:
                words = f"could not be held against it: {model.why_not}"
            console.print(f"{model.model} calibrated again: {words}", soft_wrap=True)

    emit(context, found, render)


@db.command()
def backup(
    context: typer.Context,
    file: Annotated[str, typer.Argument(help="The new file.", show_default=False)],
) -> None:
    """Copy the database to a new file, also while it is in use.

    \b
    Example:
      avahazard db backup copy.db
    """
    from avahazard.workflow.database import backup_database  # noqa: PLC0415

    found = backup_database(settings(context).database, file)
    emit(
        context,
        found,
        lambda console: console.print(
            f"Copied {found.database} to {found.backup}.", soft_wrap=True
        ),
    )
