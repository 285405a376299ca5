"""Pictures of paths, a panel each: profiles, runs of the block, zones, design and α-β runouts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.site import recorded_stops, release_place
from avahazard.hazard.alpha_beta import REGRESSIONS, AlphaBeta, alpha_beta
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.records.collection import Path, Profile, Records
from avahazard.report.picture import figure, panels, picture, shade
from avahazard.results.hazard import HazardRow, PlaceQuantiles, Spread, ZonedPath
from avahazard.results.terrain import Runout, RunoutAt

if TYPE_CHECKING:
    from matplotlib.axes import Axes


COLUMNS = 2
SMALL: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": 8}
ALONG = "horizontal distance along the path x (m)"
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
    """
    with panels(file, len(paths) + 1, COLUMNS, (5.5, height)) as (drawn, (*each, last)):
        legend: dict[str, Any] = {}
        for panel, path in zip(each, paths, strict=True):
            for axes in draw_path(panel, path):
                handles, labels = axes.get_legend_handles_labels()
                legend |= dict(zip(labels, handles, strict=True))
        last.axis("off")
        last.legend(legend.values(), legend.keys(), loc="center", frameon=False, fontsize=9)
        if title is not None:
            drawn.suptitle(title, fontsize=13)
        drawn.supxlabel(ALONG, fontsize=10)
        drawn.supylabel("elevation (m)", fontsize=10)


def draw_profile(
    panel: Axes, name: str, smooth: SmoothProfile, below: float, above: float = 2.0
) -> float:
    """Draw the profile, with room for `below` and `above` marks; returns the length of one (m)."""
    x = np.linspace(smooth.x_min, smooth.x_max, 600)
    y = smooth.height(x)
    top, bottom = float(y.max()), float(y.min())
    tick = TICK * (top - bottom)
    panel.fill_between(x, y, bottom - (below + 1.0) * tick, color=GROUND, lw=0)
    panel.plot(x, y, color="0.35", lw=1.2, label="profile, smoothed")
    panel.set_title(name, fontsize=10, loc="left", parse_math=False)
    panel.set(xlim=(smooth.x_min, smooth.x_max), ylim=(bottom - below * tick, top + above * tick))
    return tick


def draw_along(
    panel: Axes,
    smooth: SmoothProfile,
    low: float | None,
    high: float | None,
    above: float = 0.0,
    **look: Any,
) -> None:
    """Draw a line between two places (m), None the end of the profile, `above` the ground (m)."""
    low, high = (smooth.x_max if end is None else end for end in (low, high))
    x = np.linspace(low, high, 200)
    panel.plot(x, smooth.height(x) + above, solid_capstyle="butt", **look)


def mark_stops(panel: Axes, smooth: SmoothProfile, stop_x: Floats, tick: float) -> None:
    """Mark the recorded stops `stop_x` `[n_stops]` (m)."""
    y = smooth.height(stop_x)
    panel.vlines(stop_x, y - tick, y + tick, color=STOPS, lw=1.1, label="recorded stops")


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
    look = {"color": color, "lw": 4, "alpha": 0.55, "label": f"{words} 5 to 95 %"}
    draw_along(panel, smooth, runout_x.q05, runout_x.q95, above, **look)
    if runout_x.q50 is not None:
        y = float(smooth.height(runout_x.q50)) + above
        panel.vlines(runout_x.q50, y - tick, y + tick, color=color, lw=2.5, label=f"{words} median")


SHADES = {"left_profile": ("#eef2f6", "leaves the profile"), "not_released": (GROUND, "held")}
"""What frictions do under which the block does not stop on the way: a colour, and words."""


def draw_run(file: FilePath, smooth: SmoothProfile, found: Runout, *, drag: bool = False) -> None:
    """Draw the profile with the release, the way and the stop, and beneath it the speeds.

    The axis of speeds says so where no `drag` limits them.
    """
    x = np.array([place.x_m for place in found.speeds])
    speed = np.array([place.speed_m_s for place in found.speeds])
    with figure(file, (8.0, 7.0)) as drawn:
        path, speeds = drawn.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        draw_profile(path, _title(found), smooth, 1.0)
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


STYLES = ("-", "--", "-.", ":")
LEAST_KPA = 1.0


@dataclass(frozen=True, slots=True)
class DrawnZones:
    """A path with its zones."""

    name: str
    smooth: SmoothProfile
    entry: ZonedPath


def draw_zones(file: FilePath, title: str, paths: Sequence[DrawnZones]) -> None:
    """Draw one panel for each path to `file`."""
    draw_panels(file, title, paths, _draw_zones)


def _draw_zones(panel: Axes, path: DrawnZones) -> list[Axes]:
    """Draw the profile and its zones; returns the axes of these and of the pressures."""
    smooth = path.smooth
    tick = draw_profile(panel, path.name, smooth, below=3.5)
    for k, zone in enumerate(path.entry.zones):
        look: dict[str, Any] = {"color": zone.color, "lw": 5, "label": f"{zone.zone} zone"}
        draw_along(panel, smooth, zone.from_x_m, zone.to_x_m, **look)
        look |= {"lw": 1.6, "label": f"end of {zone.zone}, 5 to 95 %"}
        below = (1.2 + 0.9 * k) * tick
        draw_along(panel, smooth, zone.to_x_q05_m, zone.to_x_q95_m, -below, **look)
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
        axes.fill_between(x, low, high, color="black", alpha=0.07, lw=0)
        far = ", extrapolated" if found.extrapolated else ""
        label = f"pressure, T = {period:g} years{far} (median; band 5 to 95 %)"
        axes.plot(x, middle, color="black", lw=1.0, ls=style, label=label)
    axes.set(yscale="log", ylim=(LEAST_KPA, 1e4))
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
    """Draw the profile to `file`; `release_x` and `stop_x` (m), any number, lie on the curve."""
    with picture(file) as axes:
        x = np.linspace(smooth.x_min, smooth.x_max, 1000)
        axes.plot(profile.x_m, profile.y_m, ".", color="0.6", ms=3, label="points")
        axes.plot(x, smooth.height(x), color="black", lw=1, label=smooth.method)
        if smooth.posterior is not None:
            height, spread = smooth.height(x), INTERVAL_90 * smooth.posterior.sd(x)
            low, high = height - spread, height + spread
            shade(axes, x, (low, high), ("tab:orange", 0.4), "ground, 5 to 95 %")
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


@dataclass(frozen=True, slots=True)
class DrawnPath:
    """A path with its α-β runouts, drawn under the ground, and a row of `hazard` if there is one.

    `stop_x` (m) of the recorded stops, any number; `n_left` records lie past the profile's end.
    """

    name: str
    smooth: SmoothProfile
    stop_x: Floats
    row: HazardRow | None
    baseline: tuple[AlphaBeta, ...] = ()
    release_x: float = 0.0
    n_left: int = 0


def draw_bounds(file: FilePath, title: str, paths: Sequence[DrawnPath]) -> None:
    """Draw the rows of `hazard` to `file`, a panel for each path."""
    draw_panels(file, title, paths, _draw_bounds, height=2.6)


def _draw_bounds(panel: Axes, path: DrawnPath) -> list[Axes]:
    smooth, end, row = path.smooth, path.smooth.x_max, path.row
    assert row is not None
    tick = draw_profile(panel, path.name, smooth, below=4.5 if path.baseline else 2.0, above=8.0)
    release = path.release_x, smooth.height(path.release_x)
    panel.plot(*release, "v", color="black", label="release", ms=7)
    mark_stops(panel, smooth, path.stop_x, tick)
    design = row.design
    _mark_design(panel, smooth, row, tick)
    above = 2.2 * tick if design is None else 4.0 * tick
    words = "avalanches of its volume V:" if design is not None else "avalanches of the volume V:"
    mark_runout(panel, smooth, row.runout_x_m, above, 0.6 * tick, OF_VOLUME, words)
    leading = row.runout_x_m if design is None else design.runout_x_m
    if leading.q95 is None:
        panel.annotate("beyond", (end, smooth.height(end)), color=BOUNDS, **SMALL)
    mark_alpha_beta(panel, smooth, path.baseline, tick)
    panel.text(0.98, 0.93, _words(path, row), transform=panel.transAxes, **SMALL)
    return [panel]


def _mark_design(panel: Axes, smooth: SmoothProfile, row: HazardRow, tick: float) -> None:
    if row.design is not None:
        words = f"design runout, exceeded once in {row.return_period_years:g} years:"
        mark_runout(panel, smooth, row.design.runout_x_m, 2.2 * tick, tick, BOUNDS, words)


def _words(path: DrawnPath, row: HazardRow) -> str:
    lines, design = [], row.design
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


def draw_alpha_beta(file: FilePath, paths: Sequence[DrawnPath]) -> None:
    """Draw the α-β runouts to `file`, a panel for each path."""
    draw_panels(file, None, paths, _draw_lines)


def _draw_lines(panel: Axes, path: DrawnPath) -> list[Axes]:
    smooth = path.smooth
    tick = draw_profile(panel, path.name, smooth, below=5.0)
    mark_stops(panel, smooth, path.stop_x, tick)
    first = path.baseline[0]
    if first.beta_x is not None:
        x = [first.release_x, first.beta_x]
        y = [first.release_y, float(smooth.height(first.beta_x))]
        words = "β: from the release to where the path is 10° steep"
        panel.plot(x, y, ":o", color="black", lw=0.9, ms=4, label=words)
    else:
        panel.text(0.97, 0.9, "no β-point", transform=panel.transAxes, ha="right", fontsize=8)
    for found in path.baseline:
        _draw_line(panel, found, smooth)
    mark_alpha_beta(panel, smooth, path.baseline, tick)
    row = path.row
    if row is not None:
        _mark_design(panel, smooth, row, tick)
        if row.design is None:
            words = "model, avalanches of the volume V:"
            mark_runout(panel, smooth, row.runout_x_m, 2.2 * tick, tick, OF_VOLUME, words)
    return [panel]


def _draw_line(panel: Axes, found: AlphaBeta, smooth: SmoothProfile) -> None:
    """The line at α, to the ground or to the end of the profile."""
    if found.alpha_deg is None:
        return
    end = smooth.x_max if found.runout_x is None else found.runout_x
    drop = np.tan(np.radians(found.alpha_deg)) * (end - found.release_x)
    x, y = [found.release_x, end], [found.release_y, found.release_y - drop]
    panel.plot(x, y, color=COLORS[found.regression.name], lw=1.0)


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
        look = {"color": color, "lw": 2.5, "alpha": 0.8, "label": f"α-β, {name}: α ± 1 sd"}
        draw_along(panel, smooth, found.runout_low_x, found.runout_high_x, -down, **look)
        if found.runout_x is not None:
            panel.plot(found.runout_x, smooth.height(found.runout_x) - down, "^", color=color, ms=6)


def draw_hazard(file: FilePath, title: str, records: Records, rows: Sequence[HazardRow]) -> None:
    """Draw the rows of `hazard` to `file`, a panel each.

    The recorded stops and the α-β runouts of their paths are shown beside them.
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
