"""The option --workers: on every command that computes for long, and it sets the workers."""

from __future__ import annotations

import pytest
from typer.main import get_command

from avahazard.cli.commands_group import load
from avahazard.cli.main import COMMANDS as ENTRIES
from avahazard.cli.main import app
from avahazard.cli.workers_option import COMMANDS
from avahazard.workers import n_workers, set_workers


def test_the_commands_that_have_it() -> None:
    names = {
        entry.name
        for entry in ENTRIES
        if any("--workers" in parameter.opts for parameter in load(entry).params)
    }
    assert names == COMMANDS


@pytest.mark.parametrize(("words", "n"), [(["--workers", "7"], 7), ([], None)])
def test_it_sets_the_workers(words: list[str], n: int | None) -> None:
    default = n_workers()
    try:
        group = get_command(app)
        with group.make_context("avahazard", ["ladder"]) as context:
            command = group.get_command(context, "ladder")  # type: ignore[attr-defined]
            parsed = command.make_context("ladder", words)
        assert "workers" not in "".join(parsed.params)
        assert n_workers() == (default if n is None else n)
    finally:
        set_workers(None)
