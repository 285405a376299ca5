"""What is left of each event over the scatter of the model, with its normal (figure 6d)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.paper_posterior_figure import draw_normal
from avahazard.report.path_panels import STOPS
from avahazard.report.picture import figure


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
