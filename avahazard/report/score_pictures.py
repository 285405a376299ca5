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
from avahazard.report.sentences import verdict_words
from avahazard.results.comparison import Comparison, Rung
from avahazard.results.diagnosis import Diagnosis

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PX_PER_INCH, WIDTH_IN = 80.0, 8.5
MARKS = {
    "circle": "o", "square": "s", "diamond": "D", "triangle-up": "^", "triangle-down": "v",
    "cross": "P", "x": "X", "star": "*",
}  # fmt: skip


def draw_comparison(file: Path, comparison: Comparison) -> None:
    """Draw a comparison to `file`: the worst levels, and measured force if any."""
    force = comparison.measured_force
    drawn = [bias_figure(comparison), force_figure(force) if force else None]
    draw_figures(file, f"{comparison.model} against the records", drawn)


def draw_diagnosis(file: Path, diagnosis: Diagnosis) -> None:
    """Draw a diagnosis to `file`: the gain of every candidate beside that of chance."""
    title = verdict_words(diagnosis, diagnosis.model).split(". ")[0]
    draw_figures(file, title, [effects_figure(diagnosis)])


def draw_ladder(
    file: Path, rows: Sequence[Rung], comparisons: Mapping[str, Comparison] | None = None
) -> None:
    """Draw the rows of `ladder` to `file`; with `comparisons`, their error budgets below."""
    best = min(
        (row for row in rows if row.held_out_crps_m is not None),
        key=lambda row: row.held_out_crps_m or 0.0,
        default=None,
    )
    errors = ladder_figure(rows, "" if best is None else best.model)
    draw_figures(file, None, [errors, budget_figure(rows, comparisons or {})])


def draw_figures(file: Path, title: str | None, figures: Sequence[Figure | None]) -> None:
    """Draw figures below one another to `file`; None is left out.

    Raises `AvahazardError` where `file` is not the name of a picture.
    """
    shown = [one for one in figures if one is not None]
    heights = [one.height / PX_PER_INCH for one in shown]
    with figure(file, (WIDTH_IN, max(sum(heights), 3.0))) as whole:
        if title is not None:
            whole.suptitle(fill(title, 90), fontsize=11)
        if not shown:
            return
        panels = whole.subplots(len(shown), 1, squeeze=False, height_ratios=heights).ravel()
        for panel, one in zip(panels, shown, strict=True):
            _draw(panel, one)


def _draw(panel: Axes, one: Figure) -> None:
    x, y = one.layout["xaxis"], one.layout["yaxis"]
    rows: dict[Any, int] = {}
    if y.get("type") == "category":
        names = [name for trace in one.data for name in trace["y"]]
        rows = {name: k for k, name in enumerate(y.get("categoryarray", names[::-1])[::-1])}
        rows = {name: k for k, name in enumerate(rows)}
    start = np.zeros(len(rows))
    for trace in one.data:
        if trace["type"] == "bar":
            places = [rows[name] for name in trace["y"]]
            stacked = one.layout.get("barmode") == "stack"
            _bars(panel, trace, places, start[places] if stacked else np.zeros(len(places)))
            start[places] += trace["x"]
        else:
            _marks(panel, trace, [rows.get(value, value) for value in trace["y"]])
    if rows:
        panel.set_yticks(list(rows.values()), [unescape(name) for name in rows])
        panel.invert_yaxis()
    panel.set(xlabel=x["title"]["text"], ylabel=y["title"]["text"])
    for line in one.layout.get("shapes", ()):
        panel.axvline(line["x0"], color=line["line"]["color"], ls="--")
    for note in one.layout.get("annotations", ()):
        color = note["font"]["color"]
        place = (note["x"], 1.0)
        panel.annotate(
            note["text"], place, (3, 2), color=color, fontsize=9,
            xycoords=panel.get_xaxis_transform(), textcoords="offset points",
        )  # fmt: skip
    panel.use_sticky_edges = False
    panel.margins(x=0.12)
    if x.get("rangemode") == "tozero":
        panel.set_xlim(left=0.0)
    panel.spines[["top", "right"]].set_visible(False)
    if panel.get_legend_handles_labels()[1]:
        panel.legend(fontsize=8, frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1))


def _name(trace: Trace) -> str | None:
    shown = trace.get("showlegend", True) and trace.get("name")
    return unescape(trace["name"]) if shown else None


def _bars(panel: Axes, trace: Trace, places: list[int], left: Floats) -> None:
    x, color = np.array(trace["x"], np.float64), trace["marker"]["color"]
    panel.barh(places, x, left=left, height=0.65, color=color, label=_name(trace))
    for row, length, from_, text in zip(places, x, left, trace.get("text", ()), strict=False):
        place = (from_ + 0.5 * length, row)
        panel.annotate(unescape(text), place, ha="center", va="center", fontsize=8)


def _marks(panel: Axes, trace: Trace, y: list[Any]) -> None:
    marker, x = trace["marker"], list(trace["x"])
    error: dict[str, Any] = trace.get("error_y", {})
    if error:
        panel.errorbar(x, y, error["array"], fmt="none", ecolor=marker["color"], lw=0.6)
    mark = MARKS.get(marker["symbol"], "o")
    size = marker["size"] ** 2 / 2.0
    panel.scatter(x, y, size, marker["color"], marker=mark, label=_name(trace), zorder=3)
    if "text" in trace["mode"]:
        for a, b, text in zip(x, y, trace["text"], strict=True):
            place: Any = (a, b)
            panel.annotate(
                unescape(text), place, (7, 0), textcoords="offset points", va="center", fontsize=8
            )
