"""One run of the block: the path with its speeds, or F(μ) and F'(μ) with the run's place."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.path_panels import BOUNDS, GROUND, STOPS, draw_profile
from avahazard.report.picture import figure
from avahazard.results.terrain import Runout, RunoutAt

if TYPE_CHECKING:
    from matplotlib.axes import Axes


SHADES = {"left_profile": ("#eef2f6", "leaves the profile"), "not_released": (GROUND, "held")}
"""What frictions do under which the block does not stop on the way: a colour, and words."""


def draw_run(file: Path, smooth: SmoothProfile, found: Runout) -> None:
    """Draw the profile with the release, the way and the stop, and beneath it the speeds.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    x = np.array([place.x_m for place in found.speeds])
    speed = np.array([place.speed_m_s for place in found.speeds])
    with figure(file, (8.0, 7.0)) as drawn:
        path, speeds = drawn.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        draw_profile(path, _title(found), smooth, 1.0)
        path.plot(x, smooth.height(x), color=STOPS, linewidth=2.5, label="way of the block")
        path.plot(x[0], smooth.height(x[0]), "v", color=STOPS, markersize=8, label="release")
        if found.status == "stopped":
            path.plot(x[-1], smooth.height(x[-1]), "X", color=BOUNDS, markersize=9, label="stop")
        path.set_ylabel("elevation (m)")
        path.legend(fontsize="small")
        speeds.plot(x, speed, color=STOPS)
        speeds.set_ylim(bottom=0.0)
        speeds.set_ylabel("speed (m/s)")
        speeds.set_xlabel("horizontal distance along the path x (m)")


def draw_curve(file: Path, found: Runout) -> None:
    """Draw F(μ) by x and by elevation, and F'(μ); jumps are gaps, the run's place is marked.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    rows, jumps = found.table or (), found.jumps or ()
    shown = _stopping(rows)
    after = {jump.mu_low for jump in jumps}
    with figure(file, (10.0, 7.0)) as drawn:
        panels = drawn.subplots(2, 2, sharex=True)
        for panel, key, words in (
            (panels[0, 0], "runout_x_m", "F: stop, x (m)"),
            (panels[0, 1], "runout_elevation_m", "F: stop, elevation (m)"),
            (panels[1, 0], "dx_dmu_m", "F′: dx/dμ (m)"),
            (panels[1, 1], "dy_dmu_m", "F′: dy/dμ (m)"),
        ):
            mu, value = with_gaps(shown, key, after)
            # Points as well, since a friction between two jumps is no line.
            panel.plot(mu, value, ".-", color=STOPS, linewidth=1.5, markersize=3, label="F, F′")
            panel.axvline(found.mu, color=BOUNDS, linewidth=1.0, linestyle="--", label="the run")
            place = getattr(found, key, None)
            if place is not None and found.status == "stopped":
                panel.plot(found.mu, place, "o", color=BOUNDS, markersize=7)
            _shade(panel, shown)
            panel.set_ylabel(words)
        for panel in panels[1]:
            panel.set_xlabel("friction μ")
        panels[0, 0].legend(fontsize="small")
        drawn.suptitle(_title(found), fontsize=11)


def with_gaps(rows: Sequence[RunoutAt], key: str, jumps: set[float]) -> tuple[Floats, Floats]:
    """μ and the values of `key` where the block stops, nan between the ends of a jump.

    `jumps` are the lower frictions of the jumps.
    """
    mu, values = [], []
    for row in rows:
        value = getattr(row, key)
        mu.append(row.mu)
        values.append(np.nan if value is None or row.status != "stopped" else value)
        if row.mu in jumps:
            mu.append(row.mu)
            values.append(np.nan)
    return np.array(mu), np.array(values)


def _stopping(rows: Sequence[RunoutAt]) -> Sequence[RunoutAt]:
    """The rows from a little before the first that stops to a little after the last."""
    stopped = [j for j, row in enumerate(rows) if row.status == "stopped"]
    if not stopped:
        return rows
    room = 1 + (stopped[-1] - stopped[0]) // 20
    return rows[max(stopped[0] - room, 0) : stopped[-1] + room + 1]


def _shade(panel: Axes, rows: Sequence[RunoutAt]) -> None:
    for status, (color, words) in SHADES.items():
        mu = [row.mu for row in rows if row.status == status]
        if mu:
            panel.axvspan(min(mu), max(mu), color=color, linewidth=0, label=words)


def _title(found: Runout) -> str:
    by = f", effects of {found.model}" if found.model else ""
    return f"{found.path_id}, μ = {found.mu:.4g}{by}"
