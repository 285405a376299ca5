"""Laws of friction by least squares on their points, as the paper's figure 1."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.model.laws import law
from avahazard.report.picture import picture
from avahazard.results.friction import Fits

N_VOLUMES = 200
ROOM = 1.5
STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))


def draw_laws(file: Path, fits: Fits, volume: Floats, mu: Floats) -> None:
    """Draw the fitted laws over points of volume (m3) and apparent friction `[n_events]`.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    points = np.asarray(volume, np.float64)
    x = np.geomspace(points.min() / ROOM, points.max() * ROOM, N_VOLUMES)
    with picture(file) as axes:
        axes.plot(points, mu, "o", color="0.4", markersize=4, label=f"{len(points)} events")
        for entry, style in zip(fits.rows, STYLES, strict=False):
            item = law(entry.law)
            natural = np.array([entry.parameters[name].value for name in item.names])
            axes.plot(x, item.friction(natural, x), linestyle=style, label=item.formula)
        axes.set_xscale("log")
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("volume, m3")
        axes.set_ylabel("apparent friction μ")
        axes.legend(fontsize="small")
