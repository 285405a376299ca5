"""The options of the engine: on every command that computes for long, and they choose it."""

from __future__ import annotations

from typing import Any

import pytest
import typer
from typer.main import get_command

from avahazard.cli.main import COMMANDS, COMPUTING, load
from avahazard.cli.options import taking_requests, with_engine
from avahazard.engine import chosen
from avahazard.workers import n_workers, set_workers

OPTIONS = {"--engine", "--workers", "--scheduler"}


def test_the_commands_that_have_them() -> None:
    names = {
        name
        for name in COMMANDS
        if {option for p in load(name).params for option in p.opts} >= OPTIONS
    }
    assert names == COMPUTING


@pytest.mark.parametrize(
    ("words", "engine", "n"),
    [
        (["--workers", "7"], "local", 7),
        ([], "local", None),
        (["--engine", "processes", "--workers", "3"], "processes", 3),
        (["--engine", "dask", "--scheduler", "tcp://127.0.0.1:9"], "dask", None),
    ],
)
def test_they_choose_the_engine(words: list[str], engine: str, n: int | None) -> None:
    default = n_workers()
    seen: list[Any] = []
    app = typer.Typer()

    def look() -> None:
        seen.append((chosen().name, n_workers(), chosen().scheduler))

    app.command()(taking_requests(with_engine(look)))
    try:
        get_command(app).main(words, standalone_mode=False)
    finally:
        set_workers(None)
    scheduler = words[-1] if "--scheduler" in words else None
    assert seen == [(engine, default if n is None else n, scheduler)]
    assert chosen().name == "local"
