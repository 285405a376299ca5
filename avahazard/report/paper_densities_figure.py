"""Densities of apparent friction with their normals, as figures 2 and 3 of Ancey (2005)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.paper_posterior_figure import draw_normal
from avahazard.report.path_panels import STOPS
from avahazard.report.picture import figure
from avahazard.results.friction import FrictionDensity

if TYPE_CHECKING:
    from matplotlib.axes import Axes


COLUMNS = 3
FEWEST_BINS = 5


def draw_with_normals(
    file: Path,
    title: str,
    densities: Sequence[FrictionDensity],
    frictions: Mapping[str, Floats],
    moved: Mapping[str, Floats] | None = None,
) -> None:
    """Draw each density with its histogram and the normal of the same mean and sd.

    `frictions` `[n]` by the density's `path_id`; `moved` `[2, n_points]` is the 90 % band of the
    density when the records are moved within their errors.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    columns = min(len(densities), COLUMNS)
    rows = ceil(len(densities) / columns)
    size = (8.0, 5.0) if len(densities) == 1 else (4.0 * columns, 3.0 * rows + 0.4)
    with figure(file, size) as drawn:
        panels = drawn.subplots(rows, columns, squeeze=False, sharex=True).ravel()
        for panel, density in zip(panels, densities, strict=False):
            band = (moved or {}).get(density.path_id)
            _density(panel, density, frictions[density.path_id], band)
        for panel in panels[len(densities) :]:
            panel.axis("off")
        for panel in panels[max(len(densities) - columns, 0) : len(densities)]:
            panel.tick_params(labelbottom=True)  # nothing stands below it
        drawn.suptitle(title, fontsize=11)
        drawn.supxlabel("apparent friction μ", fontsize=10)
        drawn.supylabel("probability density", fontsize=10)


def _density(panel: Axes, density: FrictionDensity, mu: Floats, band: Floats | None) -> None:
    n_bins = max(FEWEST_BINS, round(2.0 * len(mu) ** (1 / 3)))
    panel.hist(mu, bins=n_bins, density=True, color=STOPS, alpha=0.2)
    if band is not None:
        panel.fill_between(
            density.mu, *band, color="0.5", alpha=0.5, linewidth=0,
            label="90 % when records move by their errors",
        )  # fmt: skip
    inside = np.where(density.extrapolated, np.nan, density.pdf)
    beyond = np.where(density.extrapolated, density.pdf, np.nan)
    panel.plot(
        density.mu, inside, color="black", linewidth=1.8, label=f"Holy, κ = {density.kappa:g}"
    )
    panel.plot(density.mu, beyond, "--", color="black", linewidth=0.8)
    if np.ptp(mu) > 0.0:
        draw_normal(panel, float(mu.mean()), float(mu.std(ddof=1)), "normal")
    panel.set_xlim(left=0.0)
    panel.set_ylim(0.0, 1.35 * panel.get_ylim()[1])
    whole = density.path_id == "all"
    panel.set_title(f"{'all events' if whole else density.path_id} ({density.n})", fontsize=9)
    panel.legend(fontsize="x-small", loc="upper right", frameon=False)
