"""Figures of the report as pictures in files: the same descriptions, drawn by matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import unescape
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.html.figure import Figure, Trace
from avahazard.report.html.score_figures import (
    bias_figure,
    budget_figure,
    effects_figure,
    force_figure,
    ladder_figure,
)
from avahazard.report.picture import figure
from avahazard.report.sentences import verdict_text
from avahazard.results.comparison import Comparison, Ladder
from avahazard.results.diagnosis import Diagnosis

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PX_PER_INCH, WIDTH_IN, COLUMN_IN = 80.0, 8.5, 4.8
MARKS = {
    "circle": "o", "square": "s", "diamond": "D", "triangle-up": "^", "triangle-down": "v",
    "cross": "P", "x": "X", "star": "*", "line-ns-open": "|", "line-ew-open": "_",
}  # fmt: skip
DASHES: dict[str, Any] = {
    "solid": "-", "dash": "--", "dot": ":", "dashdot": "-.", "longdash": (0, (8, 3)),
    "longdashdot": (0, (8, 3, 1, 3)),
}  # fmt: skip


def draw_comparison(file: Path, comparison: Comparison) -> None:
    """Draw a comparison to `file`: the worst levels, and measured force if any."""
    force = comparison.measured_force
    drawn = [bias_figure(comparison), force_figure(force) if force else None]
    draw_figures(file, f"{comparison.model} against the records", drawn)


def draw_diagnosis(file: Path, diagnosis: Diagnosis) -> None:
    """Draw a diagnosis to `file`: the gain of every candidate beside that of chance."""
    title = verdict_text(diagnosis, diagnosis.model).split(". ")[0]
    draw_figures(file, title, [effects_figure(diagnosis)])


def draw_ladder(
    file: Path, ladder: Ladder, comparisons: Mapping[str, Comparison] | None = None
) -> None:
    """Draw a ladder to `file`; with `comparisons`, the error budgets of its models below."""
    errors = {r.model: r.held_out_crps_m for r in ladder.rows if r.held_out_crps_m is not None}
    drawn = ladder_figure(ladder.rows, min(errors, key=lambda name: errors[name], default=""))
    draw_figures(file, None, [drawn, budget_figure(ladder.rows, comparisons or {})])


def draw_figures(
    file: Path, title: str | None, figures: Sequence[Figure | None], columns: int = 1
) -> None:
    """Draw figures to `file` below one another; None is left out.

    In several `columns` each has its title and caption over it. Raises `AvahazardError` where
    `file` is not the name of a picture.
    """
    side_by_side = columns > 1
    shown = [one for one in figures if one is not None]
    columns = max(min(columns, len(shown)), 1)
    rows = [shown[k : k + columns] for k in range(0, len(shown), columns)]
    heights = [max(one.height for one in row) / PX_PER_INCH for row in rows]
    width = WIDTH_IN if columns == 1 else COLUMN_IN * columns
    with figure(file, (width, max(sum(heights), 3.0))) as whole:
        if title is not None:
            whole.suptitle(fill(title, int(10.6 * width)), fontsize=11)
        if not shown:
            return
        # A grid in a grid: what stands in one figure keeps its own heights.
        outer = whole.add_gridspec(len(rows), columns, height_ratios=heights)
        for k, one in enumerate(shown):
            keys = [key for key in one.layout if key.startswith("yaxis")]
            parts = [np.ptp(one.layout[key].get("domain", (0.0, 1.0))) for key in keys]
            inner = outer[k // columns, k % columns].subgridspec(len(keys), 1, height_ratios=parts)
            panels = [whole.add_subplot(inner[j]) for j in range(len(keys))]
            for panel, key in zip(panels, keys, strict=True):
                _draw(panel, one, key, last=panel is panels[-1])
            words = f"{one.title}\n{one.caption}".strip() if side_by_side else None
            _legend(panels, one, words, 3 if columns == 1 else 1)


def _draw(panel: Axes, one: Figure, key: str, *, last: bool) -> None:
    """The traces of one axis upwards."""
    x, y = one.layout["xaxis"], one.layout[key]
    data = [t for t in one.data if t.get("yaxis", "y") == key.replace("axis", "")]
    rows: dict[Any, int] = {}
    if y.get("type") == "category":
        names = [name for trace in data for name in trace["y"]]
        order = dict.fromkeys(y.get("categoryarray", names[::-1])[::-1])
        rows = {name: k for k, name in enumerate(order)}
    start = np.zeros(len(rows))
    for trace in data:
        if trace["type"] == "bar" and rows:
            places = [rows[name] for name in trace["y"]]
            stacked = one.layout.get("barmode") == "stack"
            _bars(panel, trace, places, start[places] if stacked else np.zeros(len(places)))
            start[places] += trace["x"]
        elif trace["type"] == "bar":
            color = trace["marker"]["color"]
            panel.bar(trace["x"], trace["y"], trace["width"], color=color, label=_name(trace))
        elif trace.get("visible") is not False:
            _scatter(panel, trace, [rows.get(value, value) for value in trace["y"]])
    panel.use_sticky_edges = False
    panel.margins(x=0.12)
    for along, which in ((x, "x"), (y, "y")):
        _scale(panel, along, which)
    if rows:
        panel.set_yticks(list(rows.values()), [_plain(name) for name in rows])
        panel.invert_yaxis()
    if not last:
        panel.set(xlabel=None, xticklabels=[])
    for line in one.layout.get("shapes", ()):
        panel.axvline(line["x0"], color=line["line"]["color"], ls="--")
    for note in one.layout.get("annotations", ()):
        place = (note["x"], 1.0)
        panel.annotate(
            note["text"], place, (3, 2), color=note["font"]["color"], fontsize=9,
            xycoords=panel.get_xaxis_transform(), textcoords="offset points",
        )  # fmt: skip
    panel.spines[["top", "right"]].set_visible(False)


def _plain(text: str) -> str:
    """A label of HTML as plain text."""
    return unescape(text.replace("<br>", "\n"))


def _scale(panel: Axes, of: Mapping[str, Any], which: str) -> None:
    """Title, scale, range and ticks of an axis."""
    log = of.get("type") == "log"
    more: dict[str, Any] = {f"{which}label": _plain(of["title"]["text"])}
    if log:
        more[f"{which}scale"] = "log"
    if "range" in of:
        more[f"{which}lim"] = np.power(10.0, of["range"]) if log else of["range"]
    elif of.get("rangemode") == "tozero":
        more[f"{which}lim"] = (0.0, None)
    panel.set(**more)
    if "tickvals" in of:
        panel.set(**{f"{which}ticks": of["tickvals"], f"{which}ticklabels": of["ticktext"]})
    if of.get("showticklabels") is False:
        panel.set(**{f"{which}ticks": []})


def _legend(panels: Sequence[Axes], one: Figure, title: str | None, columns: int) -> None:
    """The title, and what all panels of a figure show, over the first."""
    found: dict[str, Any] = {}
    for panel in panels:
        handles, names = panel.get_legend_handles_labels()
        found |= dict(zip(names, handles, strict=True))
    if found and one.layout.get("showlegend", True):
        place: Any = {"loc": "lower left", "bbox_to_anchor": (0, 1), "alignment": "left"}
        look = {"fontsize": 8, "frameon": False, "ncols": min(len(found), columns)}
        legend = panels[0].legend(found.values(), found.keys(), title=title, **place, **look)
        for text in (legend.get_title(), *legend.get_texts()):
            text.set_parse_math(False)  # names of people, in which $ is a dollar
    elif title is not None:
        panels[0].set_title(title, fontsize=9, parse_math=False)


def _name(trace: Trace) -> str | None:
    shown = trace.get("showlegend", True) and trace.get("name")
    return unescape(trace["name"]) if shown else None


def _color(color: Any) -> Any:
    """A colour of Plotly as matplotlib has it."""
    if isinstance(color, str) and color.startswith("rgba("):
        red, green, blue, opacity = map(float, color[5:-1].split(","))
        return (red / 255.0, green / 255.0, blue / 255.0, opacity)
    return color


def _bars(panel: Axes, trace: Trace, places: list[int], left: Floats) -> None:
    x, color = np.array(trace["x"], np.float64), trace["marker"]["color"]
    panel.barh(places, x, left=left, height=0.65, color=color, label=_name(trace))
    for row, length, from_, text in zip(places, x, left, trace.get("text", ()), strict=False):
        place = (from_ + 0.5 * length, row)
        panel.annotate(unescape(text), place, ha="center", va="center", fontsize=8)


def _scatter(panel: Axes, trace: Trace, upwards: list[Any]) -> None:
    """A line, a filled one, or marks; `upwards` are the places of names."""
    x, y = np.array(trace["x"], np.float64), np.array(upwards, np.float64)
    alpha = trace.get("opacity")
    if trace.get("fill") == "toself":
        panel.fill(x, y, color=_color(trace["fillcolor"]), lw=0, alpha=alpha, label=_name(trace))
    elif "lines" in trace["mode"]:
        look = trace["line"]
        panel.plot(
            x, y, color=_color(look["color"]), lw=look["width"], ls=DASHES[look["dash"]],
            alpha=alpha, label=_name(trace), solid_capstyle="butt",
        )  # fmt: skip
    else:
        _marks(panel, trace, x, y)


def _marks(panel: Axes, trace: Trace, x: Floats, y: Floats) -> None:
    marker = trace["marker"]
    symbol, color = marker.get("symbol", "circle"), marker["color"]
    for which in ("error_x", "error_y"):
        if bar := trace.get(which):
            ends = [bar.get("arrayminus", bar["array"]), bar["array"]]
            size: Any = {which.replace("error_", "") + "err": np.abs(np.array(ends, np.float64))}
            panel.errorbar(x, y, fmt="none", ecolor=color, lw=0.6, **size)
    shape = MARKS.get(symbol, MARKS.get(symbol.removesuffix("-open"), "o"))
    look: dict[str, Any] = {"marker": shape, "zorder": 3}
    look |= {"c": color} if not symbol.endswith("-open") or symbol.startswith("line") else {
        "facecolors": "none", "edgecolors": color
    }  # fmt: skip
    alpha = trace.get("opacity", marker.get("opacity"))
    panel.scatter(x, y, np.square(marker["size"]) / 2.0, alpha=alpha, label=_name(trace), **look)
    if "text" in trace["mode"]:
        for a, b, text in zip(x, y, trace["text"], strict=True):
            panel.annotate(
                unescape(text), (a, b), (7, 0), textcoords="offset points", va="center", fontsize=8
            )
