"""Text of files and databases made safe for a terminal: what is printed obeys nobody."""

from __future__ import annotations

import json
import re

from rich.console import (
    Console,
    ConsoleOptions,
    ConsoleRenderable,
    RenderHook,
    RenderResult,
)
from rich.segment import Segment

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
