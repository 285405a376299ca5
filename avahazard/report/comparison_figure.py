"""Where a model fails: bias by level, and the force along the tracks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avahazard.report.html.words import coordinate_words
from avahazard.report.picture import figure
from avahazard.results.amounts import unit_of
from avahazard.results.comparison import Comparison, Failure, MeasuredForce

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_ROWS = 20
SIGNIFICANT = 0.05
# Told apart by colour-blind readers too.
FAILS, OTHER = "#d95f02", "0.7"


def draw_comparison(file: Path, comparison: Comparison) -> None:
    """Draw a comparison to `file`: the worst levels, and measured force if any.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    force = comparison.measured_force
    n_panels = 1 + bool(force) if comparison.where_it_fails else 1
    with figure(file, (8.0 if n_panels == 1 else 12.0, 5.0)) as drawn:
        if comparison.where_it_fails or not force:
            _draw_bias(drawn.add_subplot(1, n_panels, 1), comparison)
        if force:
            _draw_force(drawn.add_subplot(1, n_panels, n_panels), force)


def _draw_bias(axes: Axes, comparison: Comparison) -> None:
    from matplotlib.patches import Patch  # noqa: PLC0415 (slow)

    rows = list(reversed(comparison.where_it_fails[:MOST_ROWS]))
    certain = [row.p_value < SIGNIFICANT for row in rows]
    colors = [FAILS if yes else OTHER for yes in certain]
    axes.barh(np.arange(len(rows)), [row.bias_m for row in rows], color=colors, height=0.7)
    axes.set_yticks(np.arange(len(rows)), [_name(row) for row in rows], fontsize=8)
    floor = comparison.scores.runout.noise_floor_m
    axes.axvspan(-floor, floor, color="tab:blue", alpha=0.2, lw=0)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.margins(x=0.08)
    of = f"{unit_of(comparison.coordinate)} of {coordinate_words(comparison.coordinate)}"
    axes.set_xlabel(f"mean miss ({of})\n← {_less(comparison)}          {_more(comparison)} →")
    axes.set_title(f"Where {comparison.model} fails", pad=36)
    axes.spines[["top", "right"]].set_visible(False)
    patches = [Patch(color="tab:blue", alpha=0.2, label="error of one recorded runout")]
    if not all(certain):
        patches.insert(0, Patch(color=OTHER, label="could be chance"))
    if any(certain):
        patches.insert(0, Patch(color=FAILS, label=f"not chance (p < {SIGNIFICANT:g}, corrected)"))
    axes.legend(
        handles=patches,
        fontsize=8,
        ncols=2,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        frameon=False,
    )


def _name(row: Failure) -> str:
    """The level in words, with how many events it has."""
    axis = row.axis.removesuffix("_m").replace("_", " ")
    return f"{axis}: {row.level} ({row.n})"


def _draw_force(axes: Axes, force: Sequence[MeasuredForce]) -> None:
    for event in dict.fromkeys(row.event_id for row in force):
        mine = [row for row in force if row.event_id == event]
        axes.errorbar(
            [row.speed_m_s for row in mine],
            [row.force_m_s2 for row in mine],
            [row.sd_m_s2 for row in mine],
            fmt="o",
            markersize=3,
            linewidth=0.6,
        )
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_xlabel("speed u (m/s)")
    axes.set_ylabel("resisting force per mass g sinθ - u du/dξ (m/s²)")
    axes.set_title("flat: Coulomb friction; rising as u²: drag", fontsize=9)


def _less(comparison: Comparison) -> str:
    """What a negative miss (predicted less recorded, in the record's coordinate) means."""
    along = comparison.coordinate in ("x", "length")
    return "records lie farther" if along else "records stop short"


def _more(comparison: Comparison) -> str:
    along = comparison.coordinate in ("x", "length")
    return "records stop short" if along else "records lie farther"
