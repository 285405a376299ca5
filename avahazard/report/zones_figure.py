"""Zones along the paths: the profile coloured by them, with the pressures that they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np

from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.path_panels import draw_panels, draw_profile
from avahazard.results.zones import ZonedPath

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
    draw_panels(file, title, paths, _draw_path)


def _draw_path(panel: Axes, path: DrawnZones) -> list[Axes]:
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
