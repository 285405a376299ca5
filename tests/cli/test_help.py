"""The help of every command: its options are explained, its examples are right."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command
from typer.testing import CliRunner

from avahazard.cli.main import app

PROGRAM = Path(sys.executable).with_name("avahazard")


def commands(command: Any, words: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Every command that does something, with the words that call it."""
    if not hasattr(command, "list_commands"):
        yield " ".join(words), command
        return
    context = command.make_context("avahazard", [], resilient_parsing=True)
    for name in command.list_commands(context):
        yield from commands(command.get_command(context, name), (*words, name))


ALL = dict(commands(get_command(app)))


def examples(command: Any) -> list[str]:
    """The example lines of a command's help."""
    _, _, rest = command.help.partition("Example")
    return [line.strip() for line in rest.splitlines()[1:] if line.strip()]


def test_the_commands_of_groups_are_among_them() -> None:
    assert {"calibrate", "import", "db backup"} <= ALL.keys()


@pytest.mark.parametrize("name", ALL)
def test_every_argument_and_option_says_what_it_is(name: str) -> None:
    assert [p.name for p in ALL[name].params if not p.help] == []


@pytest.mark.parametrize("name", ALL)
def test_examples_call_the_command_rightly(name: str) -> None:
    lines = examples(ALL[name])
    assert lines
    for line in lines:
        words = shlex.split(line.split(" > ")[0])
        assert words.pop(0) == "avahazard"
        while words[0].startswith("-"):
            del words[: 2 if words[0] == "--db" else 1]
        assert words[: len(name.split())] == name.split()
        # Parsed, not run: unknown options and missing arguments are errors here.
        with ALL[name].make_context(name, words[len(name.split()) :]):
            pass


def asked(words: str) -> dict[str, str]:
    """What a shell sets to ask for the words that may follow."""
    return {
        "_AVAHAZARD_COMPLETE": "complete_bash",
        "COMP_WORDS": f"avahazard {words}",
        "COMP_CWORD": str(len(words.split())),
    }


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("cal", {"calibrate"}),
        ("db b", {"backup"}),
        ("calibrate --l", {"--law"}),
        ("calibrate x --law p", {"power"}),
    ],
)
def test_the_shell_completes(words: str, offered: set[str]) -> None:
    done = CliRunner().invoke(app, [], prog_name="avahazard", env=asked(words))
    assert (set(done.stdout.split()), done.stderr) == (offered, "")


def test_the_shell_completes_the_installed_command() -> None:
    done = subprocess.run(
        [PROGRAM], env=os.environ | asked("cal"), capture_output=True, text=True, check=False
    )
    assert (done.stdout.split(), done.stderr) == (["calibrate"], "")
