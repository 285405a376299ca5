"""The profile of a path with its recorded stops and predicted runouts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.html.content import Floats, PathView
from avahazard.report.html.figure import Trace, label
from avahazard.report.html.style import BLACK, GROUND, INK, ROW_COLORS
from avahazard.report.html.words import case, event_words, interval, metres, volume_words

PLACES = 160
STEP = 0.055
"""Distance of the bars from the ground and from each other, as a share of the drop."""
HUMP = 0.05
"""Height of the distribution where it is densest, as a share of the drop."""
FOOT, TOP = 0.13, 0.08
"""Room under and over the ground, as shares of the drop."""
BAR_PLACES = 24
MOST_ROWS = len(ROW_COLORS)


def profile_range(smooth: SmoothProfile, n_rows: int) -> list[float]:
    """Lowest and highest elevation of the panel, with room for the bars of `n_rows`."""
    y = smooth.height(_places(smooth))
    drop = float(np.ptp(y))
    top = max(TOP, STEP * min(n_rows, MOST_ROWS) + HUMP) if n_rows else TOP
    return [float(y.min()) - FOOT * drop, float(y.max()) + top * drop]


def profile_traces(view: PathView) -> list[Trace]:
    """Ground, release, recorded stops, and for every row its runout above the ground."""
    smooth, release = view.smooth, view.release_x
    assert smooth is not None
    assert release is not None
    x = _places(smooth)
    y = smooth.height(x)
    drop = float(np.ptp(y))
    foot = float(y.min()) - FOOT * drop
    traces: list[Trace] = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": "ground",
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
            "name": "profile, smoothed",
            "showlegend": False,
            "x": x,
            "y": y,
            "line": {"color": INK, "width": 1.4},
            "hovertemplate": "x %{x:.0f} m, %{y:.0f} m<extra></extra>",
        },
    ]
    if view.zones:
        traces += _zones(view.zones, foot, drop)
    for level, row in enumerate(view.rows[:MOST_ROWS], start=1):
        above = level * STEP * drop
        traces += _runout(smooth, row, ROW_COLORS[level - 1], above, first=level == 1)
    traces += _alpha_beta(view, smooth, 0.5 * STEP * drop)
    traces.append(
        {
            "type": "scatter",
            "mode": "markers",
            "name": "release",
            "cliponaxis": False,
            "x": [release],
            "y": [float(smooth.height(release))],
            "marker": {"symbol": "triangle-down", "size": 11, "color": BLACK},
            "hovertemplate": "release: x %{x:.0f} m, %{y:.0f} m<extra></extra>",
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
                "name": "recorded stops",
                "cliponaxis": False,
                "x": places,
                "y": smooth.height(np.clip(places, smooth.x_min, smooth.x_max)),
                "text": [label(event_words(e, names)) for e in stops],
                "hovertemplate": "%{text}<br>stopped at x %{x:.0f} m, %{y:.0f} m<extra></extra>",
                "marker": {
                    "symbol": "line-ns-open",
                    "size": 13,
                    "color": INK,
                    "line": {"width": 1.3, "color": INK},
                },
            }
        )
    return traces


def _runout(
    smooth: SmoothProfile, row: Mapping[str, Any], color: str, above: float, *, first: bool
) -> list[Trace]:
    """The design runout of a row, and thinner that of avalanches of its volume.

    The legend names the latter in the `first` row only: it stands for all.
    """
    group = f"row {case(row)}"
    traces: list[Trace] = []
    design = row.get("design")
    if design:
        name = f"design runout, {case(row)}"
        traces += _bar(smooth, design["runout_x_m"], name, group, above, color, 6.0)
    volume = row["runout_x_m"]
    if volume["q05"] is not None:
        name = f"avalanches of {volume_words(row)}"
        traces += _bar(smooth, volume, name, group, above, color, 1.2, legend=first or not design)
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
    *,
    legend: bool = True,
) -> list[Trace]:
    """The 5 to 95 % of a runout as a line `above` the ground (m), and its median as a tick."""
    if found["q05"] is None:
        return []
    end = smooth.x_max if found["q95"] is None else found["q95"]
    x = np.linspace(found["q05"], end, BAR_PLACES)
    words = f"{name}: x {interval(found)}, median {metres(found['q50'])}"
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
                "hovertemplate": f"{name}, median: x %{{x:.0f}} m<extra></extra>",
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
    upper = density / density.max() * HUMP * float(np.ptp(smooth.height(_places(smooth))))
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


def _places(smooth: SmoothProfile) -> Floats:
    return np.linspace(smooth.x_min, smooth.x_max, PLACES)


def _alpha_beta(view: PathView, smooth: SmoothProfile, below: float) -> list[Trace]:
    """The α-β runouts, under the ground."""
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
                "name": f"α-β, {row['coefficients']}",
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
                "hovertemplate": f"α-β, {row['coefficients']}: x %{{x:.0f}} m ({low:.0f} to "
                f"{high:.0f})<extra></extra>",
            }
        )
    return traces


def _zones(zones: Mapping[str, Any], foot: float, drop: float) -> list[Trace]:
    """A strip in the colour of each zone at the foot of the panel."""
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "name": label(f"zone: {zone['zone']}"),
            "x": [zone["from_x_m"], zone["to_x_m"]],
            "y": [foot + 0.03 * drop] * 2,
            "line": {"color": zone["color"], "width": 10},
            "hovertemplate": f"{label(str(zone['zone']))}: x %{{x:.0f}} m<extra></extra>",
        }
        for zone in zones["zones"]
        if zone["to_x_m"] > zone["from_x_m"]
    ]
