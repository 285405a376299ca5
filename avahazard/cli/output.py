"""What a command prints: one JSON document, or tables for people; all made safe for a terminal."""

from __future__ import annotations

import errno
import json
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from textwrap import indent
from typing import Any, TypeVar

import typer
from rich import box
from rich.console import (
    Console,
    ConsoleOptions,
    ConsoleRenderable,
    RenderHook,
    RenderResult,
)
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from avahazard.notes import grouped
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.records.plain import plain


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


LONGEST_CELL = 200
LONGEST_LINE = 4000
# Controls (C0, DEL, C1), marks that turn the direction of writing or cannot be seen, lone halves.
UNSAFE = re.compile(
    "[\x00-\x09\x0b-\x1f\x7f-\x9f\xad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff"
    "\U000e0000-\U000e007f]"
)


def safe(text: str, longest: int = LONGEST_LINE) -> str:
    """Show every sign of `text` that a terminal would obey, and cut what is longer than `longest`.

    Controls stand as their pictures (␛), other marks as �; ends of lines stay.
    """
    if len(text) > longest:
        text = text[: longest - 1] + "…"
    return UNSAFE.sub(_picture, text)


def safe_json(text: str) -> str:
    """Escape in a JSON document what a terminal would obey; it means the same."""
    # Signs past the basic plane are two halves in JSON; the document's own tabs do not occur.
    return UNSAFE.sub(lambda found: _escaped(found.group()), text)


def _escaped(sign: str) -> str:
    return "\\u007f" if sign == "\x7f" else json.dumps(sign)[1:-1]


def _picture(found: re.Match[str]) -> str:
    sign = found.group()
    if sign == "\t":
        return " "
    if sign < " ":
        return chr(0x2400 + ord(sign))
    return "␡" if sign == "\x7f" else "\N{REPLACEMENT CHARACTER}"


class SafeText:
    """Whatever is rendered, its text made safe: the last door before the terminal."""

    def __init__(self, inner: ConsoleRenderable) -> None:
        self.inner = inner

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Render the inner object; codes of its own styles are no text."""
        for segment in console.render(self.inner, options):
            if segment.control or not UNSAFE.search(segment.text):
                yield segment
            else:
                yield Segment(UNSAFE.sub(_picture, segment.text), segment.style)


class SafeHook(RenderHook):
    """The hook by which a console prints `SafeText` alone."""

    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        """Wrap all that is about to be printed."""
        return [SafeText(one) for one in renderables]


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
    """Print warnings on standard error, a line for all of one kind."""
    for text in grouped(texts):
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
