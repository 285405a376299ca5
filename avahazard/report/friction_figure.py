"""Densities of apparent friction, as figure 3 of Ancey (2005), and a model's law beside them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.html.content import FrictionView
from avahazard.report.path_panels import BOUNDS, STOPS
from avahazard.report.picture import figure, picture
from avahazard.results.friction import FrictionDensity, Frictions

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
