"""Pictures of friction and of volumes: densities, laws on their points, return levels."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.model.laws import law
from avahazard.report.html.content import FrictionView
from avahazard.report.path_pictures import BOUNDS, STOPS
from avahazard.report.picture import figure, picture
from avahazard.results.friction import Fits, FrictionDensity, Frictions
from avahazard.results.hazard import PathVolumes, ReturnLevel

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_densities(file: Path, densities: Sequence[FrictionDensity]) -> None:
    """Draw densities to `file`.

    Parts beyond the records are dashed; the density of all events is the thick line.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    with picture(file) as axes:
        _densities(axes, densities)


def draw_frictions(
    file: Path, found: Frictions, view: FrictionView | None, volume: Floats, reference: Floats
) -> None:
    """Draw the densities, and the model's law with its scatter and the events beside it.

    `volume` (m3) and `reference`, μ less what effects on friction and the path add, are
    `[n_events]`. Without a volume on record (`view` is None) there is no law to draw.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    with figure(file, (8.0, 5.0) if view is None else (12.0, 5.0)) as drawn:
        panels = drawn.subplots(1, 1 if view is None else 2, squeeze=False)[0]
        _densities(panels[0], found.density)
        if view is not None:
            _law(panels[1], view, volume, reference)
        drawn.suptitle(f"Apparent friction, with the effects of {found.model}", fontsize=11)


def _law(axes: Axes, view: FrictionView, volume: Floats, reference: Floats) -> None:
    if view.scatter is not None:
        for low, high, alpha, words in ((0, 3, 0.18, "5 to 95 %"), (1, 2, 0.3, "25 to 75 %")):
            axes.fill_between(
                view.volume,
                view.scatter[low],
                view.scatter[high],
                color=BOUNDS,
                alpha=alpha,
                linewidth=0,
                label=f"avalanches, {words}",
            )
    axes.plot(view.volume, view.law[1], color=BOUNDS, label="law, median")
    known = np.isfinite(volume) & np.isfinite(reference)
    axes.plot(
        volume[known],
        reference[known],
        "o",
        color=STOPS,
        markersize=4,
        label=f"{int(known.sum())} events",
    )
    axes.set_xscale("log")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("volume, m3")
    axes.set_ylabel("μ less effects on friction and of the path")
    axes.legend(fontsize="small")


def _densities(axes: Axes, densities: Sequence[FrictionDensity]) -> None:
    for density in densities:
        whole = density.path_id == "all"
        (line,) = axes.plot(
            density.mu,
            np.where(density.extrapolated, np.nan, density.pdf),
            color="black" if whole else None,
            linewidth=2.5 if whole else 1.2,
            label=f"{density.path_id} ({density.n})",
        )
        axes.plot(
            density.mu,
            np.where(density.extrapolated, density.pdf, np.nan),
            "--",
            color=line.get_color(),
            linewidth=0.8,
        )
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("apparent friction μ")
    axes.set_ylabel("probability density")
    axes.legend()


N_VOLUMES = 200
ROOM = 1.5
LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))


def draw_laws(file: Path, fits: Fits, volume: Floats, mu: Floats) -> None:
    """Draw the fitted laws over points of volume (m3) and apparent friction `[n_events]`.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    points = np.asarray(volume, np.float64)
    x = np.geomspace(points.min() / ROOM, points.max() * ROOM, N_VOLUMES)
    with picture(file) as axes:
        axes.plot(points, mu, "o", color="0.4", markersize=4, label=f"{len(points)} events")
        for entry, style in zip(fits.rows, LINES, strict=False):
            item = law(entry.law)
            natural = np.array([entry.parameters[name].value for name in item.names])
            axes.plot(x, item.friction(natural, x), linestyle=style, label=item.formula)
        axes.set_xscale("log")
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("volume, m3")
        axes.set_ylabel("apparent friction μ")
        axes.legend(fontsize="small")


COLUMNS = 3
FIT, RECORDS = "#c0392b", "#33607f"


def draw_return_levels(
    file: Path, entries: Sequence[PathVolumes], curves: Sequence[Sequence[ReturnLevel]]
) -> None:
    """Draw a panel for each of the `entries` of `volumes` to `file`.

    `curves` are their levels at many periods. Where they are extrapolated, the line is dotted.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    columns = min(COLUMNS, len(entries))
    rows = ceil(len(entries) / columns)
    with figure(file, (3.6 * columns + 0.6, 2.9 * rows + 0.5)) as drawn:
        panels = drawn.subplots(rows, columns, squeeze=False, sharex=True).ravel()
        for panel, entry, curve in zip(panels, entries, curves, strict=False):
            _draw(panel, entry, curve)
        for panel in panels[len(entries) :]:
            panel.axis("off")
        panels[0].legend(frameon=False, fontsize=8, loc="upper left")
        drawn.supxlabel("return period (years)", fontsize=10)
        drawn.supylabel("volume (m³)", fontsize=10)


def _draw(panel: Axes, entry: PathVolumes, curve: Sequence[ReturnLevel]) -> None:
    years = [level.return_period_years for level in curve]
    panel.fill_between(
        years,
        [level.q05_m3 for level in curve],
        [level.q95_m3 for level in curve],
        color=FIT,
        alpha=0.2,
        linewidth=0,
        label="5 to 95 %",
    )
    for far, style, label in ((False, "-", "volume of T"), (True, ":", None)):
        part = [level for level in curve if level.extrapolated is far]
        panel.plot(
            [level.return_period_years for level in part],
            [level.volume_m3 for level in part],
            style,
            color=FIT,
            label=label,
        )
    panel.plot(
        [point.return_period_years for point in entry.maxima],
        [point.volume_m3 for point in entry.maxima],
        "o",
        color=RECORDS,
        markersize=3.5,
        label="largest of a year, by rank",
    )
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.tick_params(labelbottom=True)
    panel.set_title(entry.path_id, fontsize=10, loc="left")
    panel.spines[["top", "right"]].set_visible(False)
