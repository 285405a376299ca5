"""Densities of apparent friction, as in figure 3 of Ancey (2005)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from avahazard.report.picture import picture
from avahazard.results.friction import FrictionDensity


def draw_densities(file: Path, densities: Sequence[FrictionDensity]) -> None:
    """Draw densities to `file`.

    Parts beyond the records are dashed; the density of all events is the thick line.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    with picture(file) as axes:
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
