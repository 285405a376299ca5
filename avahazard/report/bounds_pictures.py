"""Pictures of runouts by path: design runouts, their α-β baseline, and the α-β runouts alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.site import recorded_stops, release_place
from avahazard.hazard.alpha_beta import REGRESSIONS, AlphaBeta, alpha_beta
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.records.collection import Records
from avahazard.report.path_pictures import (
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
    draw_panels(file, None, paths, _draw_lines)


def _draw_lines(panel: Axes, path: AlphaBetaPath) -> list[Axes]:
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


def draw_hazard(file: FilePath, title: str, records: Records, rows: Sequence[HazardRow]) -> None:
    """Draw the rows of `hazard` to `file`, a panel each.

    The recorded stops and the α-β runouts of their paths are shown beside them.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    paths = {path.path_id: path for path in records.paths}
    smooth = {
        p.path_id: smooth_profile(p.x_m, p.y_m, p.elevation_sigma_m) for p in records.profiles
    }
    drawn = []
    for row in rows:
        path, ground = paths[row.path_id], smooth[row.path_id]
        release_x = release_place(ground, path.release_elevation_m)
        events = [e for e in records.events if e.path_id == path.path_id]
        drawn.append(
            DrawnPath(
                name=path.name or path.path_id,
                smooth=ground,
                release_x=release_x,
                stop_x=recorded_stops(ground, events),
                n_left=sum(e.left_profile for e in events),
                row=row,
                baseline=tuple(alpha_beta(ground, release_x, by) for by in REGRESSIONS),
            )
        )
    draw_bounds(file, title, drawn)
