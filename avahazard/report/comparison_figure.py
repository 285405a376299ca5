"""Where a model fails: bias by level, and the force along the tracks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from avahazard.report.picture import picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_ROWS = 20
SIGNIFICANT = 0.05


def draw_comparison(file: Path, comparison: Mapping[str, Any]) -> None:
    """Draw the document of `compare` to `file`: the worst levels, and measured force if any.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    with picture(file) as axes:
        figure = axes.figure
        axes.remove()
        force = comparison["measured_force"]
        n_panels = 1 + bool(force) if comparison["where_it_fails"] else 1
        if comparison["where_it_fails"] or not force:
            _draw_bias(figure.add_subplot(1, n_panels, 1), comparison)
        if force:
            _draw_force(figure.add_subplot(1, n_panels, n_panels), force)


def _draw_bias(axes: Axes, comparison: Mapping[str, Any]) -> None:
    rows = list(reversed(comparison["where_it_fails"][:MOST_ROWS]))
    colors = ["tab:red" if row["p_value"] < SIGNIFICANT else "0.7" for row in rows]
    axes.barh(np.arange(len(rows)), [row["bias_m"] for row in rows], color=colors)
    names = [f"{row['axis']}: {row['level']} ({row['n']})" for row in rows]
    axes.set_yticks(np.arange(len(rows)), names, fontsize=7)
    floor = comparison["scores"]["runout"]["noise_floor_m"]
    axes.axvspan(-floor, floor, color="tab:blue", alpha=0.12, label="error of one record")
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set_xlabel(f"predicted less recorded {_coordinate(comparison)} (m)")
    axes.set_title(f"{comparison['model']}: red cannot be chance (p < {SIGNIFICANT:g})", fontsize=9)
    axes.legend(fontsize=7)


def _draw_force(axes: Axes, force: list[dict[str, Any]]) -> None:
    for event in dict.fromkeys(row["event_id"] for row in force):
        mine = [row for row in force if row["event_id"] == event]
        axes.errorbar(
            [row["speed_m_s"] for row in mine],
            [row["force_m_s2"] for row in mine],
            [row["sd_m_s2"] for row in mine],
            fmt="o",
            markersize=3,
            linewidth=0.6,
        )
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_xlabel("speed u (m/s)")
    axes.set_ylabel("resisting force per mass g sinθ - u du/dξ (m/s²)")
    axes.set_title("flat: Coulomb friction; rising as u²: drag", fontsize=9)


def _coordinate(comparison: Mapping[str, Any]) -> str:
    name = str(comparison["coordinate"])
    return "runout" if name == "mixed" else name
