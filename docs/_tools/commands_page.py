"""The reference of commands, from their own help and what `outputs.md` says of their output."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from typer.main import get_command

from avahazard.cli.main import app

HEAD = """# Commands

    avahazard [OPTIONS] COMMAND …

Every command has `--help`, with examples. Results go to standard output; progress, notes and
errors go to standard error. The exit status is 0 for done, 1 when the data or the database do not
allow it (one message and a hint), 2 for wrong usage.

Completion: `avahazard --install-completion` sets it up for bash, zsh, fish or PowerShell, in
the shell that it is called from; open a new terminal afterwards. The command must then be on the
`PATH` as `avahazard` (`source .venv/bin/activate`, or a link to `.venv/bin/avahazard`).
"""


def outputs() -> dict[str, str]:
    """What each command prints, explained line by line."""
    text = Path(__file__).with_name("outputs.md").read_text(encoding="utf-8")
    sections = (section.partition("\n") for section in text.split("\n## ")[1:])
    return {name.strip(): explained.strip() for name, _, explained in sections}


def commands_page() -> str:
    """Return the page: what all commands share, then each command."""
    program = get_command(app)
    context = program.make_context("avahazard", [], resilient_parsing=True)
    parts = [
        HEAD,
        "\n## Options of all commands\n",
        "They stand before the command: `avahazard --json paths`.\n",
        _options(program, context),
        *(_section(words, command) for words, command in leaves(program)),
    ]
    return "\n".join(parts)


def leaves(command: Any, words: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Every command that does something, with the words that call it."""
    if not hasattr(command, "list_commands"):
        yield " ".join(words), command
        return
    context = command.make_context("avahazard", [], resilient_parsing=True)
    for name in command.list_commands(context):
        yield from leaves(command.get_command(context, name), (*words, name))


def _section(words: str, command: Any) -> str:
    context = command.make_context(f"avahazard {words}", [], resilient_parsing=True)
    text, _, examples = inspect.cleandoc(command.help).replace("\b", "").partition("Example")
    lines = [line.strip() for line in examples.splitlines()[1:] if line.strip()]
    anchor = words.replace(" ", "-")
    usage = " ".join(command.collect_usage_pieces(context)).replace("{", "").replace("}", "")
    return "\n".join(
        (
            f"\n## {words} {{ #{anchor} }}\n",
            text.strip(),
            f"\n    avahazard {words} {usage}\n",
            _options(command, context),
            "\nFor example:\n\n```sh\n" + "\n".join(lines) + "\n```\n",
            f"Output:\n\n{outputs()[words]}\n",
        )
    )


def _options(command: Any, context: Any) -> str:
    """A table of the arguments and options, as the help prints them."""
    rows = []
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record is not None and not ("--help" in parameter.opts and "-h" not in parameter.opts):
            name, says = (text.replace("|", "\\|") for text in record)
            rows.append(f"| `{name}` | {says} |")
    return "\n".join(["| argument or option | |", "|---|---|", *rows]) if rows else ""
