"""The options --engine, --workers, --scheduler of every command that computes for long."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

import typer
from typer.main import get_command

COMMANDS = frozenset(
    {
        "calibrate", "compare", "diagnose", "add", "ladder", "hazard", "zones", "report", "demo",
    }
)  # fmt: skip


class EngineChoice(StrEnum):
    """Who does the work."""

    local = "local"
    processes = "processes"
    dask = "dask"


def add_engine_options(command: Any) -> None:
    """Give a command the options; they choose the engine, and the command never sees them."""
    carrier = typer.Typer(rich_markup_mode=None, add_completion=False)
    carrier.command()(_carrier)
    own = [p for p in get_command(carrier).params if p.name in ("engine", "workers", "scheduler")]
    command.params.extend(own)
    inner = command.callback

    def callback(**values: Any) -> Any:
        from avahazard.cli.output import warn  # noqa: PLC0415 (help needs no engine)
        from avahazard.engine import close_engine, set_engine  # noqa: PLC0415

        engine, workers, scheduler = (values.pop(p.name) for p in own)
        try:
            set_engine(EngineChoice(engine).value, workers=workers, scheduler=scheduler, tell=warn)
            return inner(**values)
        finally:
            close_engine()

    command.callback = callback


def _carrier(
    engine: Annotated[
        EngineChoice,
        typer.Option(help="Threads, processes, or a dask cluster; results are the same."),
    ] = EngineChoice.local,
    workers: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=1024,
            metavar="N",
            help="How many share the work; results are the same. [default: the cores]",
            show_default=False,
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Of dask, such as tcp://host:8786; without it dask has workers on this machine.",
        ),
    ] = None,
) -> None:
    """Nothing but its options."""
