"""What a command prints: one JSON document, or tables for people; all made safe for a terminal."""

import errno
import json
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextvars import ContextVar
from inspect import signature
from itertools import groupby, zip_longest
from operator import attrgetter
from textwrap import TextWrapper, indent, wrap
from typing import Any, Literal, NamedTuple

import typer
from rich import box
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderableType
from rich.containers import Lines
from rich.padding import Padding
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from avahazard import workflow
from avahazard.notes import Note, grouped
from avahazard.progress import show_progress
from avahazard.records.errors import AvahazardError, RejectedRows, RowProblem
from avahazard.report import tables as report_tables
from avahazard.report.language import TERMINAL, speaking
from avahazard.report.tables import cell
from avahazard.report.words import OPEN
from avahazard.results.base import plain

Shown = str | Table | Padding | report_tables.Table | None
"""Words, a table, a table of the report with how to read it; nothing for None."""
Render = Callable[[Any], Iterable[Shown]]
"""Gives what people are shown of a result."""


class Whole(str):
    """Words that stay on their lines, however long: names of files and commands can be copied."""


class CliSettings(NamedTuple):
    """The database by path or URL, whether the output is JSON, and whether it is whole.

    `named`: the command line names the database.
    """

    database: str = ""
    as_json: bool = False
    verbose: bool = False
    named: bool = False


settings_of_command: ContextVar[CliSettings] = ContextVar("settings")


def settings() -> CliSettings:
    """The settings of the command that runs."""
    return settings_of_command.get(CliSettings())


def ask(use_case: str, **values: Any) -> Any:
    """What a use case, `module.function` of `avahazard.workflow`, returns for these values.

    None stands for what was not given. The database and the progress are given to those that
    take them.
    """
    module, name = use_case.split(".")
    run = getattr(getattr(workflow, module), name)
    values = {key: value for key, value in values.items() if value is not None}
    if "database" in signature(run).parameters:
        values["database"] = settings().database
    if "report" not in signature(run).parameters:
        return run(**values)
    with show_progress() as report:
        return run(**values, report=report)


def document_of(found: Any) -> Any:
    """What `--json` prints of a result: its rows, where that is all there is to it."""
    return getattr(found, "rows", found)


def notes_of(found: Any) -> Iterator[str]:
    """The notes of a result, or of all its rows."""
    for one in found if isinstance(found, list | tuple) else (found,):
        yield from getattr(one, "notes", None) or ()


LONGEST_CELL = 300
LEAST_HEADING = 5
"""Headings of numbers are folded to the width of these, or to so much."""
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
    return UNSAFE.sub(
        lambda found: json.dumps(found.group())[1:-1].replace("\x7f", "\\u007f"), text
    )


def _picture(found: re.Match[str]) -> str:
    sign = found.group()
    if sign == "\t":
        return " "
    if sign < " ":
        return chr(0x2400 + ord(sign))
    return "␡" if sign == "\x7f" else "\N{REPLACEMENT CHARACTER}"


NARROWEST = 80
"""Columns of a terminal, below which tables would lose some of theirs."""


class SafeConsole(Console):
    """A console whose whole output is safe, on standard output or standard error.

    Words in brackets are no markup there.
    """

    def __init__(self, *, stderr: bool = False, **more: Any) -> None:
        super().__init__(stderr=stderr, markup=False, highlight=False, emoji=False, **more)
        self.width = max(self.width, NARROWEST)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Render with text made safe; codes of its own styles are no text."""
        for segment in super().render(renderable, options):
            if segment.control or not UNSAFE.search(segment.text):
                yield segment
            else:
                yield Segment(UNSAFE.sub(_picture, segment.text), segment.style)


def emit(
    found: Any,
    render: Render,
    *,
    document: Callable[[Any], Any] = document_of,
    notes: Callable[[Any], Iterable[str]] = notes_of,
) -> None:
    """Print a result, as JSON where that was asked for, else by `render`; notes.

    A document that is an iterator is a list, of which one item is held at a time.
    """
    if settings().as_json:
        whole = document(found)
        if isinstance(whole, Iterator):
            before = "["
            for item in whole:
                typer.echo(f"{before}\n{indent(_json(item), '  ')}", nl=False)
                before = ","
            typer.echo("[]" if before == "[" else "\n]")
        else:
            typer.echo(_json(whole))
    else:
        console = SafeConsole()
        with speaking(TERMINAL):
            show(console, render(found))
        database = getattr(found, "database", settings().database)
        show_next(console, getattr(found, "next", None), database)
    warn(*notes(found))


def _json(document: Any) -> str:
    """The document as text, escaped where the encoding of standard output has not every letter."""
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    ascii_only = not encoding.lower().startswith("utf")
    return safe_json(
        json.dumps(plain(document), ensure_ascii=ascii_only, allow_nan=False, indent=2)
    )


def show_next(console: Console, step: Note | None, database: str) -> None:
    """Print the next step: why, and below it the command alone, which can be copied."""
    if step is None:
        return
    command = str(step)
    if settings().named or database != settings().database:
        option = shlex.join(("--db", database))
        command = re.sub("^avahazard ", lambda found: f"{found.group()}{option} ", command)
    console.print(f"{step.values.get('why', '')} Next:".lstrip())
    console.print(f"  {command}", soft_wrap=True)


def warn(*texts: str) -> None:
    """Print warnings on standard error, a line for all of one kind unless all are asked for."""
    for text in dict.fromkeys(texts) if settings().verbose else grouped(texts):
        SafeConsole(stderr=True).print(Text(f"Note: {safe(text)}", style="yellow"), soft_wrap=True)


def show(console: Console, parts: Iterable[Shown]) -> None:
    """Print what people are shown, one after the other. Folded rows of tables are counted."""
    for part in parts:
        if isinstance(part, report_tables.Table):
            _show_table(console, part)
        elif part is not None:
            console.print(part, soft_wrap=isinstance(part, Whole))


def _show_table(console: Console, found: report_tables.Table) -> None:
    rows = found.rows if settings().verbose else found.rows[: found.shown]
    if rows or not found.rows:
        console.print(table(found.title, found.columns, rows))
    if len(rows) < len(found.rows):
        console.print(f"{found.title}: {found.folded} (--verbose shows them).")
    for words in found.legend if rows else ():
        console.print(words)
    if any(OPEN in text for row in rows for text in row):
        console.print(f"{OPEN}: beyond the end of the profile.")
    if found.legend and rows:
        console.print()


class AtMarks(TextWrapper):
    """Breaks at blanks, and after a mark between letters, as in base+path-effect+snow_type.wet.

    And within spans of years.
    """

    wordsep_re = re.compile(r"(\s+|\S*?[^\W\d_][-+:*.](?=[^\W\d_])|\S*?\d–(?=\d))")


class AtAnyMarks(TextWrapper):
    """Breaks within names too, as in snow_type."""

    wordsep_re = re.compile(r"(\s+|\S*?[^\W_][-+:*._](?=[^\W\d_]))")


class BrokenText(Text):
    """A cell that is broken after marks too, and within a part only where that is too long."""

    def wrap(self, console: Console, width: int, **options: Any) -> Lines:
        """Return the lines of the cell, at most `width` wide."""
        lines = AtMarks(max(width, 1), break_long_words=False).wrap(self.plain)
        if max(map(len, lines), default=0) > width:
            lines = AtAnyMarks(max(width, 1), break_long_words=False).wrap(self.plain)
        return Text("\n".join(lines)).wrap(console, width, **options)


LONGEST_WORD = 14
"""Words of a table are broken where they are longer, or where it is too wide all the same."""


def _fitted(natural: list[int], least: list[int], room: int) -> tuple[list[int], int]:
    """Widths of columns and the blanks between them: the widest columns are folded to their words.

    Columns stand closer where their words would not fit else; no widths where they do not either.
    """
    n = len(natural)
    blank = int(sum(least) + 2 * n <= room)
    over = sum(natural) + (1 + blank) * (n - 1) + 2 - room
    while over > 0 and (folded := [k for k in range(n) if natural[k] > least[k]]):
        natural[max(folded, key=natural.__getitem__)] -= 1
        over -= 1
    return natural if over <= 0 else [], blank


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> Table:
    """Return a table; a heading that begins with '>' is set to the right, and never folded."""
    title = safe(title, LONGEST_CELL)
    made = Table(
        title=title or None,
        title_justify="left",
        min_width=len(title),  # a title is folded to the width of its table
        box=box.SIMPLE_HEAD,
        pad_edge=False,
    )
    with speaking(TERMINAL):
        cells = [[safe(cell(value), LONGEST_CELL) for value in row] for row in rows]
    headings, natural, least = list[str](), list[int](), list[int]()
    for k, name in enumerate(columns):
        heading, own = safe(name.removeprefix(">"), LONGEST_CELL), [row[k] for row in cells]
        if name.startswith(">"):  # half of 3.4e-06 is another number
            widest = max((len(text) for text in (*own, *heading.split())), default=0)
            heading = "\n".join(wrap(heading, max(widest, LEAST_HEADING)))
            parts = [*own, *heading.splitlines()]
            natural.append(max(map(cell_len, parts), default=0))
            least.append(natural[-1])
        else:
            natural.append(max(map(cell_len, (*own, heading))))
            words = (AtMarks(1, break_long_words=False).wrap(text) for text in (*own, heading))
            longest = max((cell_len(word) for of_text in words for word in of_text), default=0)
            least.append(min(longest, LONGEST_WORD))
        headings.append(heading)
    widths, blank = _fitted(natural, least, SafeConsole().width)
    made.padding = (0, blank, 0, 0)
    for name, heading, width in zip_longest(columns, headings, widths):
        right = name.startswith(">")
        justify: Literal["right", "left"] = "right" if right else "left"
        made.add_column(heading, justify=justify, overflow="fold", no_wrap=right, width=width)
    kinds = [Text if name.startswith(">") else BrokenText for name in columns]
    for row in cells:
        made.add_row(*(kind(text) for kind, text in zip(kinds, row, strict=True)))
    return made


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


FEW = 3


def _complaints(alike: Sequence[RowProblem]) -> list[tuple[Any, ...]]:
    """Rows of the table of problems that differ in line and value; many are one row."""
    if len(alike) <= FEW:
        return [(p.line or None, p.column, p.value, p.accepted) for p in alike]
    values = list(dict.fromkeys(p.value for p in alike))
    more = ", …" if len(values) > FEW else ""
    lines = f"{', '.join(str(p.line) for p in alike[:FEW])}, … ({len(alike)} rows)"
    return [(lines, alike[0].column, ", ".join(values[:FEW]) + more, alike[0].accepted)]


def show_error(error: AvahazardError | OSError) -> None:
    """Print an error on standard error: the rows at fault, the message, the hint."""
    console = SafeConsole(stderr=True)
    if isinstance(error, RejectedRows):
        for file, problems in groupby(error.problems, key=attrgetter("file")):
            equal: dict[tuple[str, str], list[RowProblem]] = {}
            for p in problems:
                equal.setdefault((p.column, p.accepted), []).append(p)
            rows = [row for alike in equal.values() for row in _complaints(alike)]
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
