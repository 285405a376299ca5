"""A figure of the report as plain data, and how it is put into the page without harm."""

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np
from markupsafe import Markup

from avahazard.arrays import Floats
from avahazard.report.html.content import EventView
from avahazard.report.language import say
from avahazard.report.words import event_text, interval, metres, some
from avahazard.results.base import plain
from avahazard.results.hazard import PlaceQuantiles, Spread

# Okabe and Ito's colours, which people with any kind of colour vision can tell apart.
BLUE, VERMILION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#AA4499"
ORANGE, SKY, BLACK, GREY = "#E69F00", "#56B4E9", "#000000", "#767676"
COLORS = (BLUE, VERMILION, GREEN, "#CC79A7", ORANGE, SKY, GREY, BLACK)
SYMBOLS = (
    "circle", "square", "diamond", "triangle-up", "triangle-down", "cross", "x", "star"
)  # fmt: skip
TOOLBAR_PX = 42
"""Right of the plot the toolbar has a margin of its own, so that it covers no legend."""
MARGIN = {"l": 66, "r": TOOLBAR_PX, "t": 10, "b": 50}
"""Room for four digits."""
WIDE_MARGIN = {**MARGIN, "l": 92}
GROUND, INK = "#E3DED5", "#222222"
ROW_COLORS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)


Trace = dict[str, Any]
States = Mapping[str, Mapping[int, Trace]]
"""By the name of a state, what it changes of the traces, by their number."""


def line(x: Any, y: Any, color: str, width: float = 1.5, hover: str = "", **more: Any) -> Trace:
    """A line, `dash` as Plotly has it; `hover` is shown at its places, if anything."""
    look = {"color": color, "width": width, "dash": more.pop("dash", "solid")}
    return {"type": "scatter", "mode": "lines", "x": x, "y": y, "line": look,
            **_hover(hover), **more}  # fmt: skip


def area(x: Any, low: Any, high: Any, color: str, **more: Any) -> Trace:
    """A filled band between `low` and `high` `[n]`."""
    x, low, high = (np.asarray(v) for v in (x, low, high))
    around, up = np.concatenate([x, x[::-1]]), np.concatenate([high, low[::-1]])
    return {**line(around, up, color, 0.0, **more), "fill": "toself", "fillcolor": color}


def marks(x: Any, y: Any, marker: dict[str, Any], hover: str = "", **more: Any) -> Trace:
    """Marks that look like `marker`."""
    return {"type": "scatter", "mode": "markers", "x": x, "y": y, "marker": marker,
            **_hover(hover), **more}  # fmt: skip


def event_marks(
    x: Any,
    y: Any,
    marker: dict[str, Any],
    events: Sequence[EventView],
    names: Mapping[str, str],
    hover: str = "",
    **more: Any,
) -> Trace:
    """Marks of events, which say in words what event it is, and `hover`."""
    words = "<br>".join(some("%{text}", hover))
    text = [label(event_text(event, names)) for event in events]
    return marks(x, y, marker, words, text=text, **more)


def bars(x: Any, y: Any, color: Any, hover: str = "", **more: Any) -> Trace:
    """Bars to the right, a row for each of `y`."""
    return {"type": "bar", "orientation": "h", "x": x, "y": y, "marker": {"color": color},
            **_hover(hover), **more}  # fmt: skip


def _hover(words: str) -> Trace:
    if not words:
        return {"hoverinfo": "skip"}
    return {"hovertemplate": words if "<extra>" in words else words + "<extra></extra>"}


def error_bar(low: Any, middle: Any, high: Any, color: str, **more: Any) -> dict[str, Any]:
    """The bar of a mark from `low` to `high` `[n]`."""
    middle = np.asarray(middle)
    return {"type": "data", "symmetric": False, "array": np.asarray(high) - middle,
            "arrayminus": middle - np.asarray(low), "color": color, **more}  # fmt: skip


BAR_PLACES = 24


def runout_bar(
    at: Callable[[Floats], tuple[Floats, Floats]],
    found: Spread | PlaceQuantiles,
    end: float,
    name: str,
    bar: dict[str, Any],
    median: dict[str, Any],
) -> list[Trace]:
    """The 5 to 95 % of a runout as a line, and its median as a mark.

    `at` says where places x (m) `[n]` are drawn; `end` (m) stands for those beyond the profile.
    `bar` holds colour, width and legend group of the line, `median` the look of the mark.
    """
    if found.q05 is None:
        return []
    x = np.linspace(found.q05, end if found.q95 is None else found.q95, BAR_PLACES)
    middle = metres(found.q50)
    words = say(
        "{name}: x {interval}, median {median}", name=name, interval=interval(found), median=middle
    )
    traces = [line(*at(x), hover="%{text}", name=name, text=[words] * BAR_PLACES, **bar)]
    if found.q50 is not None:
        hover = say("{name}, median: x {x}", name=name, x=middle)
        own = {"legendgroup": bar["legendgroup"], "showlegend": False}
        traces.append(marks(*at(np.array([found.q50])), median, hover, **own))
    return traces


def rows_axis(names: Sequence[str] | None = None, **more: Any) -> dict[str, Any]:
    """An axis of names from the top down: in the order of the traces, or in that of `names`."""
    order = {"autorange": "reversed"} if names is None else {"categoryarray": names[::-1]}
    return axis("", type="category", **order, **more)


def axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis; only names get the room that they need (the look of all is in `report.js`).

    Where numbers did too, margins and a legend that folds could chase each other.
    """
    return {"title": {"text": title}, "automargin": more.get("type") == "category", **more}


def layout(x: dict[str, Any], y: dict[str, Any], height: int = 420, **more: Any) -> dict[str, Any]:
    """A layout with these axes and room for four digits; the look of all is in `report.js`."""
    return {"xaxis": x, "yaxis": y, "height": height, "margin": {**MARGIN}, **more}


def by_path(
    events: Sequence[EventView], rows: Sequence[int], names: Mapping[str, str]
) -> Iterator[tuple[str, dict[str, Any], list[int]]]:
    """Name, look and `rows` of the events of each path; all in one where there are many paths.

    `names` are those of all paths with events: a path has one colour in every figure.
    """
    if len(names) > len(COLORS):
        yield say("recorded events"), {"color": BLUE, "symbol": "circle", "size": 7}, list(rows)
        return
    for path_id in dict.fromkeys(events[row].path_id for row in rows):
        k = len(COLORS) - 1 if path_id is None else list(names).index(path_id)
        name = say("recorded events") if path_id is None else names[path_id]
        look = {"color": COLORS[k], "symbol": SYMBOLS[k], "size": 7}
        yield label(name), look, [row for row in rows if events[row].path_id == path_id]


@dataclass(frozen=True, slots=True)
class Figure:
    """Traces and layout of Plotly; `key` is the figure's name in the page.

    How to read it stands in the template, with the `counts`, or is the `caption`.
    Numbers keep `digits` significant digits. `states` are what a switch of the page changes.
    """

    key: str
    title: str
    data: list[Trace]
    layout: dict[str, Any]
    caption: str = ""
    counts: Mapping[str, int] = field(default_factory=dict)
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


def script_json(value: Any, digits: int = 5) -> Markup:
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
    return escape(text, quote=False).replace("$", "&#36;")
