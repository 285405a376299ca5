"""Pictures of several paths: a panel for each, and one legend for all."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import ceil
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.picture import figure
from avahazard.results.hazard import PlaceQuantiles, Spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLUMNS = 2
GROUND, STOPS, BOUNDS, OF_VOLUME = "#d9d4cc", "#33607f", "#c0392b", "#8c8c8c"
TICK = 0.05
"""Length of a mark, of the height of the path."""

T = TypeVar("T")


def draw_panels(
    file: FilePath,
    title: str | None,
    paths: Sequence[T],
    draw_path: Callable[[Axes, T], Iterable[Axes]],
    height: float = 3.2,
) -> None:
    """Draw a panel of `height` inches for each path to `file`; the legend stands in the last.

    `draw_path` returns the axes whose marks belong in the legend.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    rows = ceil((len(paths) + 1) / COLUMNS)
    with figure(file, (11.0, height * rows + 0.5)) as drawn:
        panels = drawn.subplots(rows, COLUMNS, squeeze=False).ravel()
        legend: dict[str, Any] = {}
        for panel, path in zip(panels, paths, strict=False):
            for axes in draw_path(panel, path):
                handles, labels = axes.get_legend_handles_labels()
                legend |= dict(zip(labels, handles, strict=True))
        for panel in panels[len(paths) :]:
            panel.axis("off")
        panels[len(paths)].legend(
            legend.values(), legend.keys(), loc="center", frameon=False, fontsize=9
        )
        if title is not None:
            drawn.suptitle(title, fontsize=13)
        drawn.supxlabel("horizontal distance along the path x (m)", fontsize=10)
        drawn.supylabel("elevation (m)", fontsize=10)


def draw_profile(
    panel: Axes, name: str, smooth: SmoothProfile, below: float, above: float = 2.0
) -> float:
    """Draw the profile, with room for `below` and `above` marks; returns the length of one (m)."""
    x = np.linspace(smooth.x_min, smooth.x_max, 600)
    y = smooth.height(x)
    top, bottom = float(y.max()), float(y.min())
    tick = TICK * (top - bottom)
    panel.fill_between(x, y, bottom - (below + 1.0) * tick, color=GROUND, linewidth=0)
    panel.plot(x, y, color="0.35", linewidth=1.2, label="profile, smoothed")
    panel.set_title(name, fontsize=10, loc="left")
    panel.set_ylim(bottom - below * tick, top + above * tick)
    panel.set_xlim(smooth.x_min, smooth.x_max)
    return tick


def mark_stops(panel: Axes, smooth: SmoothProfile, stop_x: Floats, tick: float) -> None:
    """Mark the recorded stops `stop_x` `[n_stops]` (m)."""
    y = smooth.height(stop_x)
    panel.vlines(stop_x, y - tick, y + tick, color=STOPS, linewidth=1.1, label="recorded stops")


def mark_runout(
    panel: Axes,
    smooth: SmoothProfile,
    runout_x: Spread | PlaceQuantiles,
    above: float,
    tick: float,
    color: str,
    words: str,
) -> None:
    """Mark a runout `above` the ground (m): its 5 to 95 % as a bar, its median as a tick.

    What lies beyond the profile ends at its end, and has no median there.
    """
    if runout_x.q05 is None:
        return
    high = smooth.x_max if runout_x.q95 is None else runout_x.q95
    along = np.linspace(runout_x.q05, high, 200)
    panel.plot(
        along,
        smooth.height(along) + above,
        color=color,
        linewidth=4,
        alpha=0.55,
        solid_capstyle="butt",
        label=f"{words} 5 to 95 %",
    )
    if runout_x.q50 is not None:
        y = float(smooth.height(runout_x.q50)) + above
        panel.vlines(
            runout_x.q50, y - tick, y + tick, color=color, linewidth=2.5, label=f"{words} median"
        )
