"""Runout bounds of all paths in one picture: profile, recorded stops, mean and interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.alpha_beta import AlphaBeta
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.alpha_beta_figure import mark_alpha_beta
from avahazard.report.path_panels import BOUNDS, draw_panels, draw_profile, mark_bounds, mark_stops
from avahazard.results.hazard import HazardRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DrawnPath:
    """A path with a row of `hazard`; `stop_x` (m) of the recorded stops, any number.

    `baseline`: its α-β runouts, drawn under the ground.
    """

    name: str
    smooth: SmoothProfile
    release_x: float
    stop_x: Floats
    n_left: int
    row: HazardRow
    baseline: tuple[AlphaBeta, ...] = ()


def draw_bounds(file: FilePath, title: str, paths: Sequence[DrawnPath]) -> None:
    """Draw one panel for each path to `file`.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    draw_panels(file, title, paths, _draw_path, height=2.6)


def _draw_path(panel: Axes, path: DrawnPath) -> list[Axes]:
    smooth, end = path.smooth, path.smooth.x_max
    tick = draw_profile(panel, path.name, smooth, below=4.5 if path.baseline else 2.0)
    panel.plot(
        path.release_x, smooth.height(path.release_x), "v", color="black", label="release", ms=7
    )
    mark_stops(panel, smooth, path.stop_x, tick)
    spread = path.row.runout_x_m
    mark_bounds(panel, smooth, spread, tick, "runout,")
    if spread.mean is not None:
        mean = spread.mean
        panel.plot(
            mean, smooth.height(mean) + 2.2 * tick, "D", color=BOUNDS, ms=6, label="runout, mean"
        )
    if spread.q95 is None:
        panel.annotate("beyond", (end, smooth.height(end)), color=BOUNDS, fontsize=8)
    mark_alpha_beta(panel, smooth, path.baseline, tick)
    panel.text(
        0.98, 0.93, _words(path), transform=panel.transAxes, ha="right", va="top", fontsize=8
    )
    return [panel]


def _words(path: DrawnPath) -> str:
    row, x = path.row, path.row.runout_x_m
    lines = []
    if row.volume_m3 is not None:
        volume = float(f"{row.volume_m3:.3g}")
        lines.append(f"V = {volume:,.0f} m³{', extrapolated' if row.extrapolated else ''}")
    if x.mean is not None:
        lines.append(f"x = {x.mean:.0f} m ({x.q05:.0f} to {x.q95:.0f})")
    left = f", {path.n_left} ran past the end" if path.n_left else ""
    lines.append(f"{len(path.stop_x) + path.n_left} records{left}")
    return "\n".join(lines)
