"""Design runouts of all paths in one picture: profile, recorded stops, median and interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

from avahazard.arrays import Floats
from avahazard.hazard.alpha_beta import AlphaBeta
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.alpha_beta_figure import mark_alpha_beta
from avahazard.report.path_panels import (
    BOUNDS,
    OF_VOLUME,
    draw_panels,
    draw_profile,
    mark_runout,
    mark_stops,
)
from avahazard.results.hazard import HazardRow, PlaceQuantiles, Spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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
    tick = draw_profile(panel, path.name, smooth, below=4.5 if path.baseline else 2.0, above=8.0)
    panel.plot(
        path.release_x, smooth.height(path.release_x), "v", color="black", label="release", ms=7
    )
    mark_stops(panel, smooth, path.stop_x, tick)
    row, design = path.row, path.row.design
    if design is not None:
        words = f"design runout, exceeded once in {row.return_period_years:g} years:"
        mark_runout(panel, smooth, design.runout_x_m, 2.2 * tick, tick, BOUNDS, words)
    above = 2.2 * tick if design is None else 4.0 * tick
    words = "avalanches of its volume V:" if design is not None else "avalanches of the volume V:"
    mark_runout(panel, smooth, row.runout_x_m, above, 0.6 * tick, OF_VOLUME, words)
    leading = row.runout_x_m if design is None else design.runout_x_m
    if leading.q95 is None:
        panel.annotate(
            "beyond", (end, smooth.height(end)), color=BOUNDS, fontsize=8, ha="right", va="top"
        )
    mark_alpha_beta(panel, smooth, path.baseline, tick)
    panel.text(
        0.98, 0.93, _words(path), transform=panel.transAxes, ha="right", va="top", fontsize=8
    )
    return [panel]


def _words(path: DrawnPath) -> str:
    row, design = path.row, path.row.design
    lines = []
    if design is not None:
        lines.append(f"{row.return_period_years:g}-year runout x = {_x(design.runout_x_m)}")
    if row.volume_m3 is not None:
        volume = float(f"{row.volume_m3:.3g}")
        lines.append(f"V = {volume:,.0f} m³{', extrapolated' if row.extrapolated else ''}")
    if design is None:
        lines.append(f"runout x = {_x(row.runout_x_m)}")
    left = f", {path.n_left} ran past the end" if path.n_left else ""
    lines.append(f"{len(path.stop_x) + path.n_left} records{left}")
    if design is not None and design.records_beyond is not None:
        lines[-1] += f"; {design.records_beyond} past the median"
    return "\n".join(lines)


def _x(found: Spread | PlaceQuantiles) -> str:
    """The median and its 90 %."""
    middle, low, high = (
        "beyond" if v is None else f"{v:.0f}" for v in (found.q50, found.q05, found.q95)
    )
    return f"{middle} m ({low} to {high})"
