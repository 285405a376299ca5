"""Pictures that no report has: paths, runs, F(μ), laws of friction, return levels, residuals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil, floor, log10
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import cumulative_trapezoid

from avahazard.arrays import Floats
from avahazard.inference.model.laws import law
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.records.collection import Path, Profile
from avahazard.report.figure_pictures import draw_figures
from avahazard.report.html.content import FrictionView, PathView
from avahazard.report.html.figure import Figure, axis, layout, marks
from avahazard.report.html.model_figures import density_figure, law_traces, normal_line
from avahazard.report.html.path_figure import path_figure
from avahazard.report.picture import figure
from avahazard.results.friction import Fits, Frictions
from avahazard.results.hazard import PathVolumes, ReturnLevel
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
    mu = np.array([row.mu for row in rows])
    values = [getattr(row, key) if row.status == "stopped" else None for row in rows]
    low = np.flatnonzero(np.isin(mu, list(jumps)))
    gapped = np.insert(np.array(values, np.float64), low + 1, np.nan)
    return np.insert(mu, low + 1, mu[low]), gapped


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


def draw_frictions(file: FilePath, found: Frictions, law: Figure | None = None) -> None:
    """Draw the densities to `file`, and below them the law of the model (`law_figure`), if any."""
    title = found.model and f"Apparent friction, with the effects of {found.model}"
    draw_figures(file, title, [density_figure(found.density, {}), law])


def law_figure(view: FrictionView, volume: Floats, friction: Floats) -> Figure:
    """The median law of a model, its 90 %, the bands of avalanches, and the events.

    `volume` (m3) and `friction`, apparent and less what effects on friction and the path add, are
    `[n_events]`.
    """
    known = np.isfinite(volume) & np.isfinite(friction)
    look = {"color": STOPS, "size": 6, "opacity": 0.8}
    points = marks(volume[known], friction[known], look, name=f"{int(known.sum())} events")
    upwards = axis("μ without the effects on friction and of the path", rangemode="tozero")
    places = layout(axis("volume (m³)", type="log"), upwards)
    return Figure("law", "Friction against volume", [*law_traces(view), points], places)


N_VOLUMES = 200
ROOM = 1.5
LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))


def draw_laws(file: FilePath, fits: Fits, volume: Floats, mu: Floats) -> None:
    """Draw the fitted laws over points of volume (m3) and apparent friction `[n_events]`."""
    points = np.asarray(volume, np.float64)
    x = np.geomspace(points.min() / ROOM, points.max() * ROOM, N_VOLUMES)
    with figure(file) as drawn:
        axes = drawn.add_subplot()
        axes.plot(points, mu, "o", color="0.4", ms=4, label=f"{len(points)} events")
        for entry, style in zip(fits.rows, LINES, strict=False):
            item = law(entry.law)
            natural = np.array([entry.parameters[name].value for name in item.names])
            axes.plot(x, item.friction(natural, x), ls=style, label=item.formula)
        axes.set(xscale="log", ylim=(0.0, None))
        axes.set(xlabel="volume (m³)", ylabel="apparent friction μ")
        axes.legend(fontsize="small")


def _points(levels: Sequence[Any]) -> tuple[list[float], list[float]]:
    """Return periods, and their volumes."""
    return [p.return_period_years for p in levels], [p.volume_m3 for p in levels]


COLUMNS = 3


def draw_return_levels(
    file: FilePath, entries: Sequence[PathVolumes], curves: Sequence[Sequence[ReturnLevel]]
) -> None:
    """Draw a panel for each of the `entries` of `volumes` to `file`.

    `curves` are their levels at many periods. Where they are extrapolated, the line is dotted.
    """
    columns = min(len(entries), COLUMNS)
    rows = ceil(len(entries) / columns)
    with figure(file, (3.8 * columns, 2.9 * rows + 0.5)) as drawn:
        each = drawn.subplots(rows, columns, squeeze=False, sharex=True).ravel()
        for panel, entry, curve in zip(each, entries, curves, strict=False):
            _draw(panel, entry, curve)
        for panel in each[len(entries) :]:
            panel.axis("off")
        each[0].legend(frameon=False, fontsize=8, loc="upper left")
        drawn.supxlabel("return period (years)", fontsize=10)
        drawn.supylabel("volume (m³)", fontsize=10)


def _draw(panel: Axes, entry: PathVolumes, curve: Sequence[ReturnLevel]) -> None:
    years = [level.return_period_years for level in curve]
    low, high = [level.q05_m3 for level in curve], [level.q95_m3 for level in curve]
    panel.fill_between(years, low, high, color=BOUNDS, alpha=0.2, lw=0, label="5 to 95 %")
    for far, style, label in ((False, "-", "volume of T"), (True, ":", None)):
        part = [level for level in curve if level.extrapolated is far]
        panel.plot(*_points(part), style, color=BOUNDS, label=label)
    words = "largest of a year, by rank"
    panel.plot(*_points(entry.maxima), "o", color=STOPS, ms=3.5, label=words)
    panel.set(xscale="log", yscale="log")
    panel.tick_params(labelbottom=True)
    panel.set_title(entry.path_id, fontsize=10, loc="left")
    panel.spines[["top", "right"]].set_visible(False)


def draw_residuals(
    file: FilePath, model: str, standardised: Floats, expected: tuple[Floats, Floats], of: str
) -> None:
    """Draw the residuals over σ as a histogram and against quantiles.

    `standardised` `[n_events]`, all finite; `expected` is the density (x, y) that the model's
    scatter has by itself; `of` says what the residuals are of.
    """
    n = len(standardised)
    with figure(file, (11.0, 4.6)) as drawn:
        left, right = drawn.subplots(1, 2)
        bins = max(6, round(2.0 * n ** (1 / 3)))
        words = f"{n} events"
        left.hist(standardised, bins=bins, density=True, color=STOPS, alpha=0.45, label=words)
        mean, sd = float(standardised.mean()), float(standardised.std(ddof=1))
        # The mean to the second digit of its standard deviation.
        words = f"their normal: {round(mean, 1 - floor(log10(sd))):.6g} ± {sd:.2g}"
        left.plot(*normal_line(mean, sd), color=BOUNDS, label=words)
        left.plot(*expected, "--", color="black", label="scatter of the model")
        left.set(xlabel=f"residual of {of}, over σ", ylabel="probability density")
        left.set_ylim(top=1.3 * left.get_ylim()[1])
        left.legend(fontsize="small")
        x, y = expected
        below = cumulative_trapezoid(y, x, initial=0)
        quantile = np.interp((np.arange(n) + 0.5) / n, below / below[-1], x)
        right.plot(quantile, np.sort(standardised), "o", color=STOPS, ms=4)
        ends = [float(quantile[0]), float(quantile[-1])]
        right.plot(ends, ends, "--", color="black", label="as the model says")
        right.set(xlabel="quantile of the model’s scatter", ylabel="residual over σ, in order")
        right.legend(fontsize="small")
        drawn.suptitle(f"Residuals of {model}", fontsize=11)
