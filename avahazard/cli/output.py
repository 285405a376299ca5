"""What a command prints: one JSON document, or tables for people; errors apart from both."""

from __future__ import annotations

import errno
import json
import sys
from collections.abc import Callable, Iterable, Sequence
from itertools import groupby
from operator import attrgetter
from textwrap import indent
from typing import Any, TypeVar

import typer
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from avahazard.cli.settings import settings
from avahazard.cli.terminal_text import LONGEST_CELL, SafeHook, safe, safe_json
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.records.plain import plain

Row = TypeVar("Row")


def emit(context: typer.Context, document: Any, render: Callable[[Console], None]) -> None:
    """Print `document` as JSON where that was asked for, else let `render` print it."""
    if settings(context).as_json:
        text = json.dumps(plain(document), ensure_ascii=False, allow_nan=False, indent=2)
        typer.echo(safe_json(text))
    else:
        render(output())


def emit_rows(
    context: typer.Context, documents: Iterable[Any], render: Callable[[Console], None]
) -> None:
    """As `emit` of a list, one document at a time, so that it may be long."""
    if not settings(context).as_json:
        render(output())
        return
    before = "["
    for document in documents:
        text = json.dumps(plain(document), ensure_ascii=False, allow_nan=False, indent=2)
        typer.echo(f"{before}\n{indent(safe_json(text), '  ')}", nl=False)
        before = ","
    typer.echo("[]" if before == "[" else "\n]")


def output() -> Console:
    """Return the console on standard output; words in brackets are no markup there."""
    return _safe(Console(markup=False, highlight=False, emoji=False))


def errors() -> Console:
    """Return the console on standard error."""
    return _safe(Console(stderr=True, markup=False, highlight=False, emoji=False))


def _safe(console: Console) -> Console:
    console.push_render_hook(SafeHook())
    return console


def warn(*texts: str) -> None:
    """Print warnings on standard error, each on a line of its own."""
    for text in texts:
        errors().print(Text(f"Note: {safe(text)}", style="yellow"), soft_wrap=True)


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> Table:
    """Return a table; a column's name that begins with '>' is set to the right.

    Numbers are written by `number`, None as a dash.
    """
    title = safe(title, LONGEST_CELL)
    made = Table(
        title=title or None,
        title_justify="left",
        min_width=len(title),  # a title is folded to the width of its table
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    for name in columns:
        right = name.startswith(">")
        heading = safe(name.removeprefix(">"), LONGEST_CELL)
        made.add_column(heading, justify="right" if right else "left", overflow="fold")
    for row in rows:
        made.add_row(*(Text(safe(number(value), LONGEST_CELL)) for value in row))
    return made


def evenly(rows: Sequence[Row], n: int) -> list[Row]:
    """About `n` of the rows, evenly, with the first and the last."""
    last = len(rows) - 1
    return [rows[i] for i in sorted({round(k * last / n) for k in range(n + 1)})]


def number(value: Any) -> str:
    """Write a value for people: four digits where they are enough, None as a dash."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        if value != 0 and (abs(value) < 1e-3 or abs(value) >= 1e7):
            return f"{value:.3g}"
        return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    return str(value)


_MAY_NOT = "Look at the permissions of the file and of its folder, or name another one."
DISK_HINTS = {
    errno.ENOSPC: "The disk is full: make room, and do it again.",
    errno.EDQUOT: "Your share of the disk is full: make room, and do it again.",
    errno.ENOENT: "Look whether the file and its folder are there.",
    errno.EACCES: _MAY_NOT,
    errno.EPERM: _MAY_NOT,
    errno.EROFS: _MAY_NOT,
    errno.EIO: "The disk does not answer as it should: look at it before you go on.",
}


def show_error(error: AvahazardError | OSError) -> None:
    """Print an error on standard error: the rows at fault, the message, the hint."""
    console = errors()
    if isinstance(error, RejectedRows):
        for file, problems in groupby(error.problems, key=attrgetter("file")):
            rows = [(p.line or None, p.column, p.value, p.accepted) for p in problems]
            console.print(safe(file), soft_wrap=True)
            console.print(table("", (">line", "column", "value", "accepted"), rows))
    if isinstance(error, AvahazardError):
        message, hint = error.message, error.hint
    else:
        place = f": {error.filename}" if error.filename else ""
        message, hint = f"{error.strerror or error}{place}", DISK_HINTS.get(error.errno or 0, "")
    console.print(Text.assemble(("Error: ", "bold red"), safe(message)), soft_wrap=True)
    if hint:
        console.print(Text(f"Hint: {safe(hint)}"), soft_wrap=True)
    sys.stderr.flush()
