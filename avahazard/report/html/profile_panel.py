"""The profile of a path with its recorded stops and predicted runouts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.html.content import PathView, PlaceView
from avahazard.report.html.figure import BLACK, GREEN, GROUND, INK, ORANGE, ROW_COLORS, Trace, label
from avahazard.report.html.words import case, event_words, integer, interval, metres, volume_words
from avahazard.report.language import ENGLISH, Language

TREES_EVERY, ABOVE, POINTS = 0.016, 0.012, 30
"""Distance of the trees as a share of the path, their height over the ground as one of the drop,
and the points of a band."""


def place_traces(
    places: Sequence[PlaceView],
    smooth: SmoothProfile,
    end: float,
    language: Language = ENGLISH,
) -> list[Trace]:
    """A trace for each effect that acts on a part of this path, which is drawn up to `end` (m)."""
    traces: list[Trace] = []
    length = end - smooth.x_min
    for place in places:
        effect = language.effect(place.effect)
        name = label(language.say("{effect} acts here", effect=effect))
        if place.trees:
            parts = [np.arange(a, b, TREES_EVERY * length) for a, b in place.stretches]
            x = np.concatenate(parts)
            drop = float(np.ptp(smooth.height(np.linspace(smooth.x_min, smooth.x_max, 100))))
            traces.append(
                {
                    "type": "scatter",
                    "mode": "markers",
                    "name": name,
                    "x": x,
                    "y": smooth.height(x) + ABOVE * drop,
                    "marker": {"symbol": "triangle-up", "size": 9, "color": GREEN},
                    "hovertemplate": label(effect) + ": x %{x:.0f} m<extra></extra>",
                }
            )
            continue
        xs: list[float | None] = []
        ys: list[float | None] = []
        for a, b in place.stretches:
            x = np.linspace(a, b, POINTS)
            xs += [*x.tolist(), None]
            ys += [*smooth.height(x).tolist(), None]
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": name,
                "x": xs,
                "y": ys,
                "line": {"width": 7, "color": ORANGE},
                "opacity": 0.55,
                "hoverinfo": "name",
            }
        )
    return traces


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
                "name": say("α-β, {coefficients}", coefficients=say(row["coefficients"])),
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
                    coefficients=say(row["coefficients"]),
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
            "name": label(language.say("zone: {zone}", zone=language.say(zone["zone"]))),
            "x": [zone["from_x_m"], zone["to_x_m"]],
            "y": [foot + 0.03 * drop] * 2,
            "line": {"color": zone["color"], "width": 10},
            "hovertemplate": label(language.say(zone["zone"])) + ": x %{x:.0f} m<extra></extra>",
        }
        for zone in zones["zones"]
        if zone["to_x_m"] > zone["from_x_m"]
    ]
