"""Pictures of paths: profiles, runs of the block, F(μ), and the report's figures of paths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.records.collection import Path, Profile
from avahazard.report.figure_pictures import draw_figures
from avahazard.report.html.content import PathView
from avahazard.report.html.path_figure import path_figure
from avahazard.report.picture import figure
from avahazard.results.terrain import Runout, RunoutAt

if TYPE_CHECKING:
    from matplotlib.axes import Axes


ALONG = "horizontal distance along the path x (m)"
GROUND, STOPS, BOUNDS = "#d9d4cc", "#33607f", "#c0392b"


def draw_paths(
    file: FilePath, title: str | None, views: Sequence[PathView], *, drag: bool = True
) -> None:
    """Draw the report's figure of each path to `file`; `drag`: something limits their speeds."""
    figures = [(view.name, path_figure(k, view, drag=drag)) for k, view in enumerate(views)]
    named = [one and replace(one, title=name) for name, one in figures]
    draw_figures(file, title, named, columns=2)


SHADES = {
    "left_profile": ("#eef2f6", "beyond the profile"),
    "not_released": (GROUND, "not released"),
}
"""What frictions do under which the block does not stop on the way: a colour, and words."""


def draw_run(file: FilePath, smooth: SmoothProfile, found: Runout, *, drag: bool = False) -> None:
    """Draw the profile with the release, the way and the stop, and beneath it the speeds.

    The axis of speeds says so where no `drag` limits them.
    """
    x = np.array([place.x_m for place in found.speeds])
    speed = np.array([place.speed_m_s for place in found.speeds])
    with figure(file, (8.0, 7.0)) as drawn:
        path, speeds = drawn.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        ground = np.linspace(smooth.x_min, smooth.x_max, 600)
        height = smooth.height(ground)
        path.fill_between(ground, height, float(height.min()), color=GROUND)
        path.plot(ground, height, color="0.35", lw=1.2, label="profile, smoothed")
        path.set_title(_title(found), fontsize=10, loc="left", parse_math=False)
        path.plot(x, smooth.height(x), color=STOPS, lw=2.5, label="way of the block")
        path.plot(x[0], smooth.height(x[0]), "v", color=STOPS, ms=8, label="release")
        if found.status == "stopped":
            path.plot(x[-1], smooth.height(x[-1]), "X", color=BOUNDS, ms=9, label="stop")
        path.set_ylabel("elevation (m)")
        path.legend(fontsize="small")
        speeds.plot(x, speed, color=STOPS)
        words = "speed (m/s)" if drag else "speed without drag (m/s)"
        speeds.set(ylim=(0.0, None), ylabel=words, xlabel=ALONG)


def draw_curve(file: FilePath, found: Runout) -> None:
    """Draw F(μ) by x and by elevation, and F'(μ); jumps are gaps, the run's place is marked."""
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
            panel.plot(mu, value, ".-", color=STOPS, lw=1.5, ms=3, label="F, F′")
            panel.axvline(found.mu, color=BOUNDS, lw=1.0, ls="--", label="the run")
            place = getattr(found, key, None)
            if place is not None and found.status == "stopped":
                panel.plot(found.mu, place, "o", color=BOUNDS, ms=7)
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
            panel.axvspan(min(mu), max(mu), color=color, lw=0, label=words)


def _title(found: Runout) -> str:
    by = f", effects of {found.model}" if found.model else ""
    return f"{found.path_id}, μ = {found.mu:.4g}{by}"


INTERVAL_90 = 1.645
"""Standard deviations from the middle to the 5 and 95 % of a normal distribution."""


def draw_path(
    file: FilePath,
    path: Path,
    profile: Profile,
    smooth: SmoothProfile,
    release_x: Floats,
    stop_x: Floats,
) -> None:
    """Draw the profile to `file`; `release_x` and `stop_x` (m), any number, lie on the curve."""
    with figure(file) as drawn:
        axes = drawn.add_subplot()
        x = np.linspace(smooth.x_min, smooth.x_max, 1000)
        axes.plot(profile.x_m, profile.y_m, ".", color="0.6", ms=3, label="points")
        axes.plot(x, smooth.height(x), color="black", lw=1, label=smooth.method)
        if smooth.posterior is not None:
            height, spread = smooth.height(x), INTERVAL_90 * smooth.posterior.sd(x)
            axes.fill_between(
                x, height - spread, height + spread, color="tab:orange", alpha=0.4, lw=0,
                label="ground, 5 to 95 %",
            )  # fmt: skip
        for place, mark, color, label in (
            (release_x, "v", "tab:blue", "releases"),
            (stop_x, "|", "tab:red", "recorded stops"),
        ):
            if len(place):
                height = smooth.height(place)
                axes.plot(place, height, mark, color=color, ms=9, label=label)
        axes.set(xlabel=ALONG, ylabel="elevation (m)")
        axes.set_title(path.name or path.path_id, parse_math=False)
        axes.legend()
