"""The option --workers, which every command that computes for long has."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.main import get_command

COMMANDS = frozenset(
    {
        "calibrate", "compare", "diagnose", "add", "ladder", "hazard", "zones", "report", "demo",
    }
)  # fmt: skip


def _choose(n: int | None) -> None:
    from avahazard.workers import set_workers  # noqa: PLC0415 (help needs no threads)

    set_workers(n)


def workers_option() -> Any:
    """The option as a command's parameter; it sets the workers, and the command never sees it."""
    carrier = typer.Typer(rich_markup_mode=None, add_completion=False)
    carrier.command()(_carrier)
    return get_command(carrier).params[0]


def _carrier(
    _workers: Annotated[
        int | None,
        typer.Option(
            "--workers",
            min=1,
            max=1024,
            metavar="N",
            help="Threads that share the work; results are the same. [default: the cores]",
            show_default=False,
            callback=_choose,
            expose_value=False,
        ),
    ] = None,
) -> None:
    """Nothing but its option."""
