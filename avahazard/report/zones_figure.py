"""Zones along the paths: the profile coloured by them, with the pressures that they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.picture import figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GROUND = "#d9d4cc"
STYLES = ("-", "--", "-.", ":")
LEAST_KPA = 1.0
COLUMNS = 2


@dataclass(frozen=True, slots=True)
class ZonedPath:
    """A path with its entry of `zones`."""

    name: str
    smooth: SmoothProfile
    entry: dict[str, Any]


def draw_zones(file: FilePath, title: str, paths: Sequence[ZonedPath]) -> None:
    """Draw one panel for each path to `file`.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    rows = ceil((len(paths) + 1) / COLUMNS)
    with figure(file, (11.0, 3.2 * rows + 0.5)) as drawn:
        panels = drawn.subplots(rows, COLUMNS, squeeze=False).ravel()
        legend: dict[str, Any] = {}
        for panel, path in zip(panels, paths, strict=False):
            for axes in (panel, _draw_path(panel, path)):
                handles, labels = axes.get_legend_handles_labels()
                legend |= dict(zip(labels, handles, strict=True))
        for panel in panels[len(paths) :]:
            panel.axis("off")
        panels[len(paths)].legend(
            legend.values(), legend.keys(), loc="center", frameon=False, fontsize=9
        )
        drawn.suptitle(title, fontsize=13)
        drawn.supxlabel("distance along the path x (m)", fontsize=10)
        drawn.supylabel("elevation (m)", fontsize=10)


def _draw_path(panel: Axes, path: ZonedPath) -> Axes:
    """Draw the profile and its zones; returns the axes of the pressures."""
    smooth = path.smooth
    x = np.linspace(smooth.x_min, smooth.x_max, 600)
    y = smooth.height(x)
    top, bottom = float(y.max()), float(y.min())
    tick = 0.05 * (top - bottom)
    panel.fill_between(x, y, bottom - 4.0 * tick, color=GROUND, linewidth=0)
    panel.plot(x, y, color="0.35", linewidth=1.0)
    for k, zone in enumerate(path.entry["zones"]):
        along = np.linspace(zone["from_x_m"], zone["to_x_m"], 100)
        panel.plot(
            along,
            smooth.height(along),
            color=zone["color"],
            linewidth=5,
            solid_capstyle="butt",
            label=f"{zone['zone']} zone",
        )
        low, high = (
            smooth.x_max if zone[key] is None else zone[key] for key in ("to_x_q05_m", "to_x_q95_m")
        )
        ends = np.linspace(low, high, 60)
        panel.plot(
            ends,
            smooth.height(ends) - (1.2 + 0.9 * k) * tick,
            color=zone["color"],
            linewidth=1.6,
            label=f"end of {zone['zone']}, 5 to 95 %",
        )
    panel.set_title(path.name, fontsize=10, loc="left")
    panel.set_ylim(bottom - 3.5 * tick, top + 2.0 * tick)
    panel.set_xlim(smooth.x_min, smooth.x_max)
    return _draw_pressures(panel, path.entry)


def _draw_pressures(panel: Axes, entry: dict[str, Any]) -> Axes:
    axes = panel.twinx()
    places = entry["places"]
    x = [place["x_m"] for place in places]
    for k, found in enumerate(places[0]["by_return_period"]):
        period = found["return_period_years"]
        low, middle, high = (
            np.array([place["by_return_period"][k]["pressure_kpa"][q] for place in places])
            for q in ("q05", "q50", "q95")
        )
        style = STYLES[k % len(STYLES)]
        axes.fill_between(x, low, high, color="black", alpha=0.07, linewidth=0)
        far = ", extrapolated" if found["extrapolated"] else ""
        label = f"pressure, T = {period:g} years{far} (median; band 5 to 95 %)"
        axes.plot(x, middle, color="black", linewidth=1.0, linestyle=style, label=label)
    axes.set_yscale("log")
    axes.set_ylim(LEAST_KPA, 1e4)
    axes.set_ylabel("pressure (kPa)", fontsize=8)
    axes.tick_params(labelsize=8)
    return axes
