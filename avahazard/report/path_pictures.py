"""Pictures of paths, a panel each: profiles with their points, runs of the block, zones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.records.path import Path, Profile
from avahazard.report.picture import figure, picture
from avahazard.results.hazard import PlaceQuantiles, Spread
from avahazard.results.terrain import Runout, RunoutAt
from avahazard.results.zones import ZonedPath

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
    panel.set_title(name, fontsize=10, loc="left", parse_math=False)
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


SHADES = {"left_profile": ("#eef2f6", "leaves the profile"), "not_released": (GROUND, "held")}
"""What frictions do under which the block does not stop on the way: a colour, and words."""


def draw_run(file: FilePath, smooth: SmoothProfile, found: Runout, *, drag: bool = False) -> None:
    """Draw the profile with the release, the way and the stop, and beneath it the speeds.

    The axis of speeds says so where no `drag` limits them.

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
        speeds.set_ylabel("speed (m/s)" if drag else "speed without drag (m/s)")
        speeds.set_xlabel("horizontal distance along the path x (m)")


def draw_curve(file: FilePath, found: Runout) -> None:
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


STYLES = ("-", "--", "-.", ":")
LEAST_KPA = 1.0


@dataclass(frozen=True, slots=True)
class DrawnZones:
    """A path with its zones."""

    name: str
    smooth: SmoothProfile
    entry: ZonedPath


def draw_zones(file: FilePath, title: str, paths: Sequence[DrawnZones]) -> None:
    """Draw one panel for each path to `file`.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    draw_panels(file, title, paths, _draw_zones)


def _draw_zones(panel: Axes, path: DrawnZones) -> list[Axes]:
    """Draw the profile and its zones; returns the axes of these and of the pressures."""
    smooth = path.smooth
    tick = draw_profile(panel, path.name, smooth, below=3.5)
    for k, zone in enumerate(path.entry.zones):
        along = np.linspace(zone.from_x_m, zone.to_x_m, 100)
        panel.plot(
            along,
            smooth.height(along),
            color=zone.color,
            linewidth=5,
            solid_capstyle="butt",
            label=f"{zone.zone} zone",
        )
        low, high = (smooth.x_max if x is None else x for x in (zone.to_x_q05_m, zone.to_x_q95_m))
        ends = np.linspace(low, high, 60)
        panel.plot(
            ends,
            smooth.height(ends) - (1.2 + 0.9 * k) * tick,
            color=zone.color,
            linewidth=1.6,
            label=f"end of {zone.zone}, 5 to 95 %",
        )
    return [panel, _draw_pressures(panel, path.entry)]


def _draw_pressures(panel: Axes, entry: ZonedPath) -> Axes:
    axes = panel.twinx()
    places = entry.places
    x = [place.x_m for place in places]
    for k, found in enumerate(places[0].by_return_period):
        period = found.return_period_years
        here = [place.by_return_period[k].pressure_kpa for place in places]
        low, middle, high = np.array([(p.q05, p.q50, p.q95) for p in here]).T
        style = STYLES[k % len(STYLES)]
        axes.fill_between(x, low, high, color="black", alpha=0.07, linewidth=0)
        far = ", extrapolated" if found.extrapolated else ""
        label = f"pressure, T = {period:g} years{far} (median; band 5 to 95 %)"
        axes.plot(x, middle, color="black", linewidth=1.0, linestyle=style, label=label)
    axes.set_yscale("log")
    axes.set_ylim(LEAST_KPA, 1e4)
    axes.set_ylabel("pressure (kPa)", fontsize=8)
    axes.tick_params(labelsize=8)
    return axes


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
    """Draw the profile to `file`; `release_x` and `stop_x` (m), any number, lie on the curve.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    with picture(file) as axes:
        x = np.linspace(smooth.x_min, smooth.x_max, 1000)
        axes.plot(profile.x_m, profile.y_m, ".", color="0.6", markersize=3, label="points")
        axes.plot(x, smooth.height(x), color="black", linewidth=1, label=smooth.method)
        if smooth.posterior is not None:
            height, spread = smooth.height(x), INTERVAL_90 * smooth.posterior.sd(x)
            axes.fill_between(
                x,
                height - spread,
                height + spread,
                color="tab:orange",
                alpha=0.4,
                linewidth=0,
                label="ground, 5 to 95 %",
            )
        for place, mark, color, label in (
            (release_x, "v", "tab:blue", "releases"),
            (stop_x, "|", "tab:red", "recorded stops"),
        ):
            if len(place):
                height = smooth.height(place)
                axes.plot(place, height, mark, color=color, markersize=9, label=label)
        axes.set_xlabel("horizontal distance along the path x (m)")
        axes.set_ylabel("elevation (m)")
        axes.set_title(path.name or path.path_id, parse_math=False)
        axes.legend()
