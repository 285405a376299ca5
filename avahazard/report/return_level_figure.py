"""Volume against return period: the fit with its interval, and the records by their rank."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

from avahazard.report.picture import figure
from avahazard.results.volumes import PathVolumes, ReturnLevel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
