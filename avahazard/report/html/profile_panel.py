"""The profile of a path with its recorded stops and predicted runouts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.html.content import PathView
from avahazard.report.html.figure import Trace, label
from avahazard.report.html.runout_bars import HUMP, ground_places, runout_traces
from avahazard.report.html.style import BLACK, GROUND, INK, ROW_COLORS
from avahazard.report.html.words import event_words, integer
from avahazard.report.language import ENGLISH, Language

STEP = 0.055
"""Distance of the bars from the ground and from each other, as a share of the drop."""
FOOT, TOP = 0.13, 0.08
"""Room under and over the ground, as shares of the drop."""
MOST_ROWS = len(ROW_COLORS)


def profile_range(smooth: SmoothProfile, n_rows: int) -> list[float]:
    """Lowest and highest elevation of the panel, with room for the bars of `n_rows`."""
    y = smooth.height(ground_places(smooth))
    drop = float(np.ptp(y))
    top = max(TOP, STEP * min(n_rows, MOST_ROWS) + HUMP) if n_rows else TOP
    return [float(y.min()) - FOOT * drop, float(y.max()) + top * drop]


def profile_traces(view: PathView, language: Language = ENGLISH) -> list[Trace]:
    """Ground, release, recorded stops, and for every row its runout above the ground."""
    say = language.say
    smooth, release = view.smooth, view.release_x
    assert smooth is not None
    assert release is not None
    x = ground_places(smooth)
    y = smooth.height(x)
    drop = float(np.ptp(y))
    foot = float(y.min()) - FOOT * drop
    traces: list[Trace] = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": say("ground"),
            "showlegend": False,
            "x": [*x.tolist(), float(x[-1]), float(x[0])],
            "y": [*y.tolist(), foot, foot],
            "fill": "toself",
            "fillcolor": GROUND,
            "line": {"width": 0},
            "hoverinfo": "skip",
        },
        {
            "type": "scatter",
            "mode": "lines",
            "name": say("profile, smoothed"),
            "showlegend": False,
            "x": x,
            "y": y,
            "line": {"color": INK, "width": 1.4},
            "hovertemplate": say("x {x} m, {y} m", x="%{x:.0f}", y="%{y:.0f}") + "<extra></extra>",
        },
    ]
    if view.zones:
        traces += _zones(view.zones, foot, drop, language)
    for level, row in enumerate(view.rows[:MOST_ROWS], start=1):
        above = level * STEP * drop
        traces += runout_traces(
            smooth, row, ROW_COLORS[level - 1], above, first=level == 1, language=language
        )
    traces += _alpha_beta(view, smooth, 0.5 * STEP * drop, language)
    traces.append(
        {
            "type": "scatter",
            "mode": "markers",
            "name": say("release"),
            "cliponaxis": False,
            "x": [release],
            "y": [float(smooth.height(release))],
            "marker": {"symbol": "triangle-down", "size": 11, "color": BLACK},
            "hovertemplate": say("release: x {x} m, {y} m", x="%{x:.0f}", y="%{y:.0f}")
            + "<extra></extra>",
        }
    )
    stops = [e for e in view.events if e.stop_x_m is not None]
    if stops:
        places = np.array([e.stop_x_m for e in stops], dtype=np.float64)
        names = {view.path.path_id: view.name}
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": say("recorded stops"),
                "cliponaxis": False,
                "x": places,
                "y": smooth.height(np.clip(places, smooth.x_min, smooth.x_max)),
                "text": [label(event_words(e, names, language)) for e in stops],
                "hovertemplate": "%{text}<br>"
                + say("stopped at x {x} m, {y} m", x="%{x:.0f}", y="%{y:.0f}")
                + "<extra></extra>",
                "marker": {
                    "symbol": "line-ns-open",
                    "size": 13,
                    "color": INK,
                    "line": {"width": 1.3, "color": INK},
                },
            }
        )
    return traces


def _alpha_beta(
    view: PathView, smooth: SmoothProfile, below: float, language: Language
) -> list[Trace]:
    """The α-β runouts, under the ground."""
    say = language.say
    traces: list[Trace] = []
    for number, row in enumerate(view.alpha_beta):
        place = row["runout_x_m"]
        if place is None:
            continue
        low, high = row["runout_x_low_m"], row["runout_x_high_m"]
        low = place if low is None else low
        high = smooth.x_max if high is None else high
        color = ("#6B5400", "#7A3E9D")[number % 2]
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": say("α-β, {coefficients}", coefficients=language.told(row["coefficients"])),
                "x": [place],
                "y": [float(smooth.height(place)) - (1.0 + number) * below],
                "error_x": {
                    "type": "data",
                    "symmetric": False,
                    "array": [high - place],
                    "arrayminus": [place - low],
                    "color": color,
                },
                "marker": {"symbol": "star", "size": 12, "color": color},
                "hovertemplate": say(
                    "α-β, {coefficients}: x {x} m ({low} to {high})",
                    coefficients=language.told(row["coefficients"]),
                    x="%{x:.0f}",
                    low=integer(low, language),
                    high=integer(high, language),
                )
                + "<extra></extra>",
            }
        )
    return traces


def _zones(zones: Mapping[str, Any], foot: float, drop: float, language: Language) -> list[Trace]:
    """A strip in the colour of each zone at the foot of the panel."""
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "name": label(language.say("zone: {zone}", zone=language.told(zone["zone"]))),
            "x": [zone["from_x_m"], zone["to_x_m"]],
            "y": [foot + 0.03 * drop] * 2,
            "line": {"color": zone["color"], "width": 10},
            "hovertemplate": label(language.told(zone["zone"])) + ": x %{x:.0f} m<extra></extra>",
        }
        for zone in zones["zones"]
        if zone["to_x_m"] > zone["from_x_m"]
    ]
