"""The α-β runout in pictures: lines from the release, and marks beside a model's bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.alpha_beta import AlphaBeta
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.path_panels import (
    BOUNDS,
    OF_VOLUME,
    draw_panels,
    draw_profile,
    mark_runout,
    mark_stops,
)
from avahazard.results.hazard import HazardRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes


COLORS = {
    "norway": "#009e73",
    "austria": "#e69f00",
    "avaframe": "#cc79a7",
    "avaframe-small": "#56b4e9",
}


@dataclass(frozen=True, slots=True)
class AlphaBetaPath:
    """A path with its α-β runouts and recorded stops (m); `row` of `hazard`, if there is one."""

    name: str
    smooth: SmoothProfile
    found: tuple[AlphaBeta, ...]
    stop_x: Floats
    row: HazardRow | None


def draw_alpha_beta(file: FilePath, paths: Sequence[AlphaBetaPath]) -> None:
    """Draw one panel for each path to `file`.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    draw_panels(file, None, paths, _draw_path)


def _draw_path(panel: Axes, path: AlphaBetaPath) -> list[Axes]:
    smooth = path.smooth
    tick = draw_profile(panel, path.name, smooth, below=5.0)
    mark_stops(panel, smooth, path.stop_x, tick)
    first = path.found[0]
    if first.beta_x is not None:
        panel.plot(
            [first.release_x, first.beta_x],
            [first.release_y, float(smooth.height(first.beta_x))],
            color="black",
            linewidth=0.9,
            linestyle=":",
            marker="o",
            markersize=4,
            label="β: from the release to where the path is 10° steep",
        )
    else:
        panel.text(0.97, 0.9, "no β-point", transform=panel.transAxes, ha="right", fontsize=8)
    for found in path.found:
        _draw_line(panel, found, smooth)
    mark_alpha_beta(panel, smooth, path.found, tick)
    row = path.row
    if row is not None and row.design is not None:
        words = f"design runout, exceeded once in {row.return_period_years:g} years:"
        mark_runout(panel, smooth, row.design.runout_x_m, 2.2 * tick, tick, BOUNDS, words)
    elif row is not None:
        words = "model, avalanches of the volume V:"
        mark_runout(panel, smooth, row.runout_x_m, 2.2 * tick, tick, OF_VOLUME, words)
    return [panel]


def _draw_line(panel: Axes, found: AlphaBeta, smooth: SmoothProfile) -> None:
    """The line at α, to the ground or to the end of the profile."""
    if found.alpha_deg is None:
        return
    end = smooth.x_max if found.runout_x is None else found.runout_x
    drop = np.tan(np.radians(found.alpha_deg)) * (end - found.release_x)
    panel.plot(
        [found.release_x, end],
        [found.release_y, found.release_y - drop],
        color=COLORS[found.regression.name],
        linewidth=1.0,
    )


def mark_alpha_beta(
    panel: Axes, smooth: SmoothProfile, both: Sequence[AlphaBeta], tick: float
) -> None:
    """Runouts as marks under the ground, with a bar of one standard deviation of α each way.

    A bar that ends at the profile's end goes on beyond it. `tick` is the distance of the marks.
    """
    for k, found in enumerate(both):
        if found.runout_low_x is None:
            continue
        color, name = COLORS[found.regression.name], found.regression.name
        down = (1.6 + 1.3 * k) * tick
        high = smooth.x_max if found.runout_high_x is None else found.runout_high_x
        along = np.linspace(found.runout_low_x, high, 60)
        panel.plot(
            along,
            smooth.height(along) - down,
            color=color,
            linewidth=2.5,
            alpha=0.8,
            solid_capstyle="butt",
            label=f"α-β, {name}: α ± 1 sd",
        )
        if found.runout_x is not None:
            panel.plot(found.runout_x, smooth.height(found.runout_x) - down, "^", color=color, ms=6)
