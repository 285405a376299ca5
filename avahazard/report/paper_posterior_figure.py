"""Posterior marginals with their normals, as figures 4 and 6a to c of Ancey (2005)."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice
from math import ceil, floor, log10
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.path_panels import BOUNDS, STOPS
from avahazard.report.picture import figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes


BINS = 40
COLUMNS = 3
MOST_PANELS = 11
"""Parameters shown: one more panel is for the first two together, and rows of three are full."""
JOINT_DRAWS = 1500
LEVELS = (0.5, 0.9)


def draw_posterior(
    file: Path, model: str, draws: Mapping[str, Floats], units: Mapping[str, str]
) -> None:
    """Draw a histogram of each parameter with the normal of its mean and sd, and a joint of two.

    `draws` `[n_draws]` by name in the order to be shown; `units` by the same names. Those that do
    not move are left out.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    moving = {name: v for name, v in draws.items() if np.ptp(v) > 0.0}
    shown = dict(islice(moving.items(), MOST_PANELS))
    n_panels = len(shown) + (len(shown) > 1)
    rows = max(ceil(n_panels / COLUMNS), 1)
    columns = max(min(n_panels, COLUMNS), 1)
    with figure(file, (4.0 * columns, 3.3 * rows + 0.4)) as drawn:
        panels = drawn.subplots(rows, columns, squeeze=False).ravel()
        for panel, (name, values) in zip(panels, shown.items(), strict=False):
            _marginal(panel, name, values, units.get(name, ""))
        if len(shown) > 1:
            _joint(panels[len(shown)], *islice(shown.items(), 2))
        for panel in panels[n_panels:]:
            panel.axis("off")
        left_out = f" (the first {len(shown)} of {len(moving)})" if len(moving) > len(shown) else ""
        drawn.suptitle(f"Posterior of {model}{left_out}, with normal approximations", fontsize=11)


def normal_density(x: Floats, mean: float, sd: float) -> Floats:
    """The density of a normal at x `[n_points]`."""
    return np.asarray(np.exp(-0.5 * ((x - mean) / sd) ** 2) / (sd * np.sqrt(2.0 * np.pi)))


def draw_normal(panel: Axes, mean: float, sd: float, words: str) -> None:
    """Draw a normal over four standard deviations on either side; it leads the legend."""
    x = np.linspace(mean - 4.0 * sd, mean + 4.0 * sd, 201)
    told = f"{words}: {_to_digits_of(mean, sd):.6g} ± {sd:.2g}"
    panel.plot(x, normal_density(x, mean, sd), color=BOUNDS, label=told)


def _to_digits_of(mean: float, sd: float) -> float:
    """The mean to the second digit of its standard deviation."""
    return round(mean, 1 - floor(log10(sd)))


def _marginal(panel: Axes, name: str, values: Floats, unit: str) -> None:
    panel.hist(values, bins=BINS, density=True, color=STOPS, alpha=0.45)
    draw_normal(panel, float(values.mean()), float(values.std(ddof=1)), "normal")
    panel.set_xlabel(f"{name} ({unit})" if unit else name)
    panel.set_yticks([])
    panel.set_ylim(top=1.25 * panel.get_ylim()[1])
    panel.ticklabel_format(axis="x", style="sci", scilimits=(-3, 4))
    panel.legend(fontsize="small", loc="upper center", frameon=False)


def _joint(panel: Axes, one: tuple[str, Floats], other: tuple[str, Floats]) -> None:
    """Draws of two parameters, and the ellipses that hold 50 and 90 % of their joint normal."""
    x, y = one[1], other[1]
    every = max(1, len(x) // JOINT_DRAWS)
    panel.plot(x[::every], y[::every], ".", color=STOPS, markersize=2, alpha=0.4)
    root = np.linalg.cholesky(np.cov(x, y) + 1e-12 * np.diag([x.var(), y.var()]))
    angle = np.linspace(0.0, 2.0 * np.pi, 121)
    circle = np.stack([np.cos(angle), np.sin(angle)])
    for level, style in zip(LEVELS, ("-", "--"), strict=True):
        # χ² with two degrees of freedom is exponential.
        ring = root @ circle * np.sqrt(-2.0 * np.log1p(-level))
        panel.plot(
            x.mean() + ring[0], y.mean() + ring[1], style, color=BOUNDS,
            label=f"normal, {100 * level:.0f} %",
        )  # fmt: skip
    panel.set_xlabel(one[0])
    panel.set_ylabel(other[0])
    panel.ticklabel_format(style="sci", scilimits=(-3, 4))
    panel.set_title(f"correlation {np.corrcoef(x, y)[0, 1]:.2f}".replace("-", "−"), fontsize=9)
    panel.legend(fontsize="small")
