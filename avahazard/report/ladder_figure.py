"""The held-out error from model to model, down to the floor, and where it comes from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avahazard.report.budget_parts import bars, part_words, parts_in_order
from avahazard.report.html.words import coordinate_words
from avahazard.report.picture import figure, picture
from avahazard.results.amounts import RATIO, amount, unit_of
from avahazard.results.comparison import Comparison
from avahazard.results.ladder import Rung

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH = 0.6
LEAST_SHARE = 0.06
"""Of the longest bar of the budgets: shorter parts have no figure in them."""
# Told apart by colour-blind readers too.
FELL, ROSE, LEVEL = "#1b9e77", "#d95f02", "0.82"


def draw_ladder(
    file: Path, rows: Sequence[Rung], comparisons: Mapping[str, Comparison] | None = None
) -> None:
    """Draw the rows of `ladder` to `file`, as a waterfall; with `comparisons`, their budgets below.

    The error of each model, and what it gained or lost against its parent. Models that were not
    compared are left out.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    shown = [(row, row.held_out_crps_m) for row in rows if row.held_out_crps_m is not None]
    budgets = bars([row.model for row, _ in shown], comparisons or {})
    if not budgets:
        with picture(file) as axes:
            _waterfall(axes, shown)
        return
    with figure(file, (8.0, 6.0 + 0.45 * len(budgets))) as whole:
        above, below = whole.subplots(2, height_ratios=[5.0, 1.2 + 0.4 * len(budgets)])
        _waterfall(above, shown)
        _draw_budgets(below, budgets, _coordinate(shown))


def _draw_budgets(axes: Axes, budgets: Mapping[str, Mapping[str, float]], coordinate: str) -> None:
    """One stacked bar a model: squares of the parts, with their metres (or H/L) in them."""
    names = list(budgets)
    start = np.zeros(len(names))
    longest = max(sum(v * v for v in bar.values()) for bar in budgets.values())
    for source, color in parts_in_order(budgets).items():
        metres = np.array([bar.get(source, 0.0) for bar in budgets.values()])
        axes.barh(
            names,
            metres**2,
            left=start,
            height=WIDTH,
            color=color,
            label=part_words(source),
        )
        for k, value in enumerate(metres):
            if value * value >= LEAST_SHARE * longest:
                middle = start[k] + 0.5 * value * value
                text = amount(value, coordinate, 0)
                axes.text(middle, k, text, ha="center", va="center", fontsize=8)
        start += metres**2
    axes.invert_yaxis()
    unit = "H/L" if coordinate == RATIO else "metres"
    axes.set_xlabel(f"square of the error on its own records; figures in {unit}")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)


def _coordinate(shown: Sequence[tuple[Rung, float]]) -> str:
    """The coordinate of the records."""
    return (shown[0][0].coordinate if shown else None) or "mixed"


def _waterfall(axes: Axes, shown: Sequence[tuple[Rung, float]]) -> None:
    coordinate = _coordinate(shown)
    place = {row.model: k for k, (row, _) in enumerate(shown)}
    for k, (row, value) in enumerate(shown):
        axes.bar(k, value, color=LEVEL, width=WIDTH)
        low = value
        at = place.get(row.parent or "")
        if at is not None:
            # From the parent's error, carried over, to the child's.
            before = shown[at][1]
            change, low = value - before, min(value, before)
            color = FELL if change < 0.0 else ROSE
            axes.bar(k, -change, bottom=value, color=color, width=WIDTH)
            axes.plot([at - WIDTH / 2, k + WIDTH / 2], [before, before], color="0.4", lw=0.8)
            sign = "−" if change < 0.0 else "+"
            text = f"{sign}{amount(abs(change), coordinate, 0)} ({sign}{abs(change) / before:.0%})"
            axes.annotate(
                text,
                (k, max(value, before)),
                (0, 3),
                textcoords="offset points",
                ha="center",
                color=color,
            )
        axes.annotate(
            amount(value, coordinate, 0),
            (k, low),
            (0, -4),
            textcoords="offset points",
            ha="center",
            va="top",
            weight="bold",
        )
    floors = [row.noise_floor_crps_m for row, _ in shown if row.noise_floor_crps_m]
    if floors:
        axes.axhspan(0.0, min(floors), color="tab:blue", alpha=0.25, lw=0)
        axes.axhline(
            min(floors),
            color="tab:blue",
            linestyle="--",
            label=f"errors of the data alone: {amount(min(floors), coordinate, 0)}",
        )
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    axes.margins(y=0.1)
    axes.set_ylim(bottom=0.0)
    axes.set_xticks(np.arange(len(shown)), [_label(row) for row, _ in shown])
    of = f"{unit_of(coordinate)} of {coordinate_words(coordinate)}"
    axes.set_ylabel(f"error: CRPS where held out ({of})")
    axes.spines[["top", "right"]].set_visible(False)


def _label(row: Rung) -> str:
    added = "\n".join(f"+ {key}" for key in row.added)
    return f"{row.model}\n{added}" if added else row.model
