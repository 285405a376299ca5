"""The figures of Ancey (2005) from the records and stored models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from math import ceil, floor, log10
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.html.content import FrictionView
from avahazard.report.path_pictures import BOUNDS, STOPS
from avahazard.report.picture import figure, picture
from avahazard.results.friction import FrictionDensity

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


# Told apart by colour-blind readers too (Okabe and Ito).
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKS = ("o", "s", "^", "D", "v", "P", "X")


@dataclass(frozen=True, slots=True, eq=False)
class ModelLaw:
    """A model's law with its scatter, and the events that it is a law of.

    `volume` (m3) and `friction`, apparent and less what effects on friction and the path add,
    are `[n_events]`.
    """

    name: str
    view: FrictionView
    volume: Floats
    friction: Floats


def draw_model_laws(file: Path, laws: Sequence[ModelLaw]) -> None:
    """Draw the median law, its 90 %, the band of 90 % of avalanches, and the events, by model.

    Events that an earlier model shows already, with the same frictions, are not drawn again.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    with picture(file) as axes:
        drawn: list[ModelLaw] = []
        for k, law in enumerate(laws):
            color, mark = COLORS[k % len(COLORS)], MARKS[k % len(MARKS)]
            view = law.view
            low, middle, high = view.law
            if not any(_same(law, other) for other in drawn):
                known = np.isfinite(law.volume) & np.isfinite(law.friction)
                axes.plot(
                    law.volume[known], law.friction[known], mark, color=color, markersize=4,
                    alpha=0.6, markeredgewidth=0, label=f"{law.name}: {int(known.sum())} events",
                )  # fmt: skip
                drawn.append(law)
            if view.scatter is not None:
                axes.fill_between(
                    view.volume, view.scatter[0], view.scatter[3], color=color, alpha=0.13,
                    linewidth=0, label=f"{law.name}: 90 % of avalanches",
                )  # fmt: skip
                for edge in (view.scatter[0], view.scatter[3]):
                    axes.plot(view.volume, edge, ":", color=color, linewidth=0.9)
            axes.plot(
                view.volume, middle, color=color, linewidth=2, label=f"{law.name}: law, median"
            )
            axes.plot(view.volume, low, "--", color=color, linewidth=0.9)
            axes.plot(
                view.volume, high, "--", color=color, linewidth=0.9, label=f"{law.name}: law, 90 %"
            )
        axes.set_xscale("log")
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("volume (m³)")
        axes.set_ylabel("friction μ")
        axes.legend(fontsize="x-small", ncols=2 if len(laws) > 2 else 1)


def _same(one: ModelLaw, other: ModelLaw) -> bool:
    return (
        one.volume.shape == other.volume.shape
        and np.array_equal(one.volume, other.volume, equal_nan=True)
        and np.allclose(one.friction, other.friction, rtol=1e-3, equal_nan=True)
    )


def draw_residuals(
    file: Path, model: str, standardised: Floats, expected: tuple[Floats, Floats], of: str
) -> None:
    """Draw the residuals over σ as a histogram and against quantiles.

    `standardised` `[n_events]`, all finite; `expected` is the density (x, y) that the model's
    scatter has by itself; `of` says what the residuals are of.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    n = len(standardised)
    with figure(file, (11.0, 4.6)) as drawn:
        left, right = drawn.subplots(1, 2)
        bins = max(6, round(2.0 * n ** (1 / 3)))
        left.hist(
            standardised, bins=bins, density=True, color=STOPS, alpha=0.45, label=f"{n} events"
        )
        mean, sd = float(standardised.mean()), float(standardised.std(ddof=1))
        draw_normal(left, mean, sd, "their normal")
        left.plot(*expected, "--", color="black", label="scatter of the model")
        left.set_xlabel(f"residual of {of}, over σ")
        left.set_ylabel("probability density")
        left.set_ylim(top=1.3 * left.get_ylim()[1])
        left.legend(fontsize="small")
        x, y = expected
        below = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(x))])
        share = (np.arange(n) + 0.5) / n
        quantile = np.interp(share, below / below[-1], x)
        right.plot(quantile, np.sort(standardised), "o", color=STOPS, markersize=4)
        ends = [float(quantile[0]), float(quantile[-1])]
        right.plot(ends, ends, "--", color="black", label="as the model says")
        right.set_xlabel("quantile of the model’s scatter")
        right.set_ylabel("residual over σ, in order")
        right.legend(fontsize="small")
        drawn.suptitle(f"Residuals of {model}", fontsize=11)
