"""Pictures of friction and of volumes: densities, laws, return levels, figures of Ancey (2005)."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import cumulative_trapezoid

from avahazard.arrays import Floats
from avahazard.inference.model.laws import law
from avahazard.report.figure_pictures import draw_figures
from avahazard.report.html.content import FrictionView
from avahazard.report.html.figure import Figure, axis, layout, marks
from avahazard.report.html.model_figures import density_figure, law_traces, normal_line
from avahazard.report.path_pictures import BOUNDS, STOPS
from avahazard.report.picture import figure
from avahazard.results.friction import Fits, Frictions
from avahazard.results.hazard import PathVolumes, ReturnLevel

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_frictions(file: Path, found: Frictions, law: Figure | None = None) -> None:
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


def draw_laws(file: Path, fits: Fits, volume: Floats, mu: Floats) -> None:
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
FIT, RECORDS = "#c0392b", "#33607f"


def draw_return_levels(
    file: Path, entries: Sequence[PathVolumes], curves: Sequence[Sequence[ReturnLevel]]
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
    panel.fill_between(years, low, high, color=FIT, alpha=0.2, lw=0, label="5 to 95 %")
    for far, style, label in ((False, "-", "volume of T"), (True, ":", None)):
        part = [level for level in curve if level.extrapolated is far]
        panel.plot(*_points(part), style, color=FIT, label=label)
    words = "largest of a year, by rank"
    panel.plot(*_points(entry.maxima), "o", color=RECORDS, ms=3.5, label=words)
    panel.set(xscale="log", yscale="log")
    panel.tick_params(labelbottom=True)
    panel.set_title(entry.path_id, fontsize=10, loc="left")
    panel.spines[["top", "right"]].set_visible(False)


def draw_residuals(
    file: Path, model: str, standardised: Floats, expected: tuple[Floats, Floats], of: str
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
