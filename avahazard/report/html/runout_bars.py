"""The runouts of a path above its ground: bars, medians and distributions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.html.figure import Trace
from avahazard.report.html.words import case, interval, metres, volume_words
from avahazard.report.language import ENGLISH, Language

PLACES = 160
HUMP = 0.05
"""Height of the distribution where it is densest, as a share of the drop."""
BAR_PLACES = 24


def runout_traces(
    smooth: SmoothProfile,
    row: Mapping[str, Any],
    color: str,
    above: float,
    *,
    first: bool,
    language: Language = ENGLISH,
) -> list[Trace]:
    """The design runout of a row, and thinner that of avalanches of its volume.

    The legend names the latter in the `first` row only: it stands for all.
    """
    of = case(row, language)
    group = f"row {of}"
    traces: list[Trace] = []
    design = row.get("design")
    if design:
        name = language.say("design runout, {case}", case=of)
        found = design["runout_x_m"]
        traces += _bar(smooth, found, name, group, above, color, 6.0, language)
    volume = row["runout_x_m"]
    if volume["q05"] is not None:
        name = language.say("avalanches of {volume}", volume=volume_words(row, language))
        shown = first or not design
        traces += _bar(smooth, volume, name, group, above, color, 1.2, language, legend=shown)
        traces += _spread(smooth, row, color, above, group)
    return traces


def _bar(
    smooth: SmoothProfile,
    found: Mapping[str, float | None],
    name: str,
    group: str,
    above: float,
    color: str,
    width: float,
    language: Language,
    *,
    legend: bool = True,
) -> list[Trace]:
    """The 5 to 95 % of a runout as a line `above` the ground (m), and its median as a tick."""
    if found["q05"] is None:
        return []
    end = smooth.x_max if found["q95"] is None else found["q95"]
    x = np.linspace(found["q05"], end, BAR_PLACES)
    words = language.say(
        "{name}: x {interval}, median {median}",
        name=name,
        interval=interval(found, language),
        median=metres(found["q50"], language),
    )
    traces: list[Trace] = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": name,
            "legendgroup": group,
            "showlegend": legend,
            "x": x,
            "y": smooth.height(x) + above,
            "line": {"color": color, "width": width},
            "opacity": 0.8,
            "text": [words] * BAR_PLACES,
            "hovertemplate": "%{text}<extra></extra>",
        }
    ]
    middle = found["q50"]
    if middle is not None:
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "legendgroup": group,
                "showlegend": False,
                "x": [middle],
                "y": [float(smooth.height(middle)) + above],
                "marker": {"symbol": "line-ns-open", "size": 9 + width, "color": color,
                           "line": {"width": 1.0 + width / 3.0, "color": color}},
                "hovertemplate": language.say("{name}, median: x {x} m", name=name, x="%{x:.0f}")
                + "<extra></extra>",
            }
        )  # fmt: skip
    return traces


def _spread(
    smooth: SmoothProfile, row: Mapping[str, Any], color: str, above: float, group: str
) -> list[Trace]:
    """The distribution of the runout upon its bar: equal areas hold equal shares."""
    steps = [float(x) for x in row.get("runout_x_steps_m", ()) if x is not None]
    x, width = np.array(steps), np.diff(steps)
    if len(x) < 3 or np.any(width <= 0.0):
        return []
    middle = 0.5 * (x[1:] + x[:-1])
    density = np.interp(x, middle, 1.0 / width)
    upper = density / density.max() * HUMP * float(np.ptp(smooth.height(ground_places(smooth))))
    base = smooth.height(x) + above
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "legendgroup": group,
            "showlegend": False,
            "x": [*x.tolist(), *x[::-1].tolist()],
            "y": [*(base + upper).tolist(), *base[::-1].tolist()],
            "fill": "toself",
            "fillcolor": color,
            "opacity": 0.3,
            "line": {"width": 0, "color": color, "shape": "linear"},
            "hoverinfo": "skip",
        }
    ]


def ground_places(smooth: SmoothProfile) -> Floats:
    """Where the ground is drawn, x (m)."""
    return np.linspace(smooth.x_min, smooth.x_max, PLACES)
