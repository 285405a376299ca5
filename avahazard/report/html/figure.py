"""A figure of the report as plain data, and how it is put into the page without harm."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from markupsafe import Markup

from avahazard.records.plain import plain

Trace = dict[str, Any]
States = Mapping[str, Mapping[int, Trace]]
"""By the name of a state, what it changes of the traces, by their number."""


@dataclass(frozen=True, slots=True)
class Figure:
    """Traces and layout of Plotly, with words for those who cannot see them.

    `key` is the figure's name in the page; `words` say what is drawn; `caption` how to read it.
    Numbers keep `digits` significant digits. `states` are what a switch of the page changes.
    """

    key: str
    title: str
    words: str
    caption: str
    data: list[Trace]
    layout: dict[str, Any]
    digits: int = 5
    states: States = field(default_factory=dict)

    @property
    def height(self) -> int:
        """Height in pixels."""
        return int(self.layout["height"])

    @property
    def json(self) -> Markup:
        """Traces and layout as JSON."""
        drawn: dict[str, Any] = {"data": self.data, "layout": self.layout}
        if self.states:
            drawn["states"] = self.states
        return script_json(drawn, self.digits)


def script_json(value: Any, digits: int) -> Markup:
    """JSON that may stand inside a `script` element: no text in it can end the element."""
    text = json.dumps(
        rounded(plain(value), digits), ensure_ascii=False, allow_nan=False, separators=(",", ":")
    )
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)  # noqa: S704 (no sign of it can end the element)


def rounded(value: Any, digits: int) -> Any:
    """The value with every float cut to so many significant digits: what a screen can show."""
    if isinstance(value, dict):
        return {key: rounded(item, digits) for key, item in value.items()}
    if isinstance(value, list):
        return [rounded(item, digits) for item in value]
    if isinstance(value, float) and value:
        short = round(value, digits - 1 - math.floor(math.log10(abs(value))))
        return int(short) if short == int(short) else short
    return value


def label(text: str) -> str:
    """Words of a user inside a figure, where Plotly reads a few marks of HTML and of TeX."""
    for sign, name in (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("$", "&#36;")):
        text = text.replace(sign, name)
    return text
