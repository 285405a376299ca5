"""What the options before the command say."""

from __future__ import annotations

from dataclasses import dataclass

import typer


@dataclass(frozen=True, slots=True)
class CliSettings:
    """The database by path or URL, and whether the output is JSON."""

    database: str
    as_json: bool


def settings(context: typer.Context) -> CliSettings:
    """Return the settings of a running command."""
    found = context.obj
    assert isinstance(found, CliSettings)
    return found
