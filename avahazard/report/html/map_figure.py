"""A path seen from above: its line, the recorded stops and the runouts."""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np

from avahazard.report.html.content import Floats, PathView, PlanView
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.hillshade import hillshade
from avahazard.report.html.style import BLACK, INK, ROW_COLORS, TOOLBAR_PX, axis, layout
from avahazard.report.html.words import case, event_words, interval

MARGIN = {"l": 92, "r": TOOLBAR_PX, "t": 10, "b": 50}
BAR_PLACES = 24
EDGE = 0.08
"""Room around what is drawn, as a share of its size."""


def map_figure(k: int, view: PathView) -> Figure | None:
    """The plan of a path; None where it has no coordinates."""
    plan = view.plan
    if plan is None or view.smooth is None or view.release_x is None:
        return None
    degrees = plan.crs is None
    data: list[Trace] = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": "path",
            "x": plan.east,
            "y": plan.north,
            "line": {"color": INK, "width": 1.6},
            "hoverinfo": "skip",
        }
    ]
    zones = view.zones["zones"] if view.zones else ()
    for zone in (zone for zone in zones if zone["to_x_m"] > zone["from_x_m"]):
        east, north = _along(plan, zone["from_x_m"], zone["to_x_m"])
        data.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": label(f"zone: {zone['zone']}"),
                "x": east,
                "y": north,
                "line": {"color": zone["color"], "width": 12},
                "opacity": 0.5,
                "hoverinfo": "name",
            }
        )
    for number, row in enumerate(view.rows[: len(ROW_COLORS)]):
        data += _runout(plan, row, ROW_COLORS[number], 9.0 - 1.5 * number)
    stops = [e for e in view.events if e.stop_x_m is not None]
    if stops:
        names = {view.path.path_id: view.name}
        east, north = _at(plan, np.array([e.stop_x_m for e in stops], dtype=np.float64))
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": "recorded stops",
                "x": east,
                "y": north,
                "text": [label(event_words(e, names)) for e in stops],
                "hovertemplate": "%{text}<extra></extra>",
                "marker": {"symbol": "circle-open", "size": 7, "color": INK,
                           "line": {"width": 1.2}},
            }
        )  # fmt: skip
    east, north = _at(plan, np.array([view.release_x]))
    data.append(
        {
            "type": "scatter",
            "mode": "markers",
            "name": "release",
            "x": east,
            "y": north,
            "marker": {"symbol": "triangle-down", "size": 11, "color": BLACK},
            "hovertemplate": "release<extra></extra>",
        }
    )
    return Figure(
        f"map-{k}",
        "Seen from above",
        f"{view.name} on the map, with the recorded stops and the predicted runouts.",
        _caption(plan),
        data,
        _layout(plan, degrees),
        digits=9,
    )


def _layout(plan: PlanView, degrees: bool) -> dict[str, Any]:
    east, north = _span(plan.east), _span(plan.north)
    ratio = 1.0 / math.cos(math.radians(float(np.mean(plan.north)))) if degrees else 1.0
    size = max(east[1] - east[0], (north[1] - north[0]) * ratio)
    room = EDGE * size
    places = layout(
        axis("longitude (°)" if degrees else "easting (m)", nticks=5, tickformat=_ticks(degrees),
             range=[east[0] - room, east[1] + room]),
        axis("latitude (°)" if degrees else "northing (m)", nticks=6, tickformat=_ticks(degrees),
             range=[north[0] - room / ratio, north[1] + room / ratio],
             scaleanchor="x", scaleratio=ratio),
        height=520,
        margin=MARGIN,
    )  # fmt: skip
    if plan.ground is not None:
        ground = plan.ground
        n_rows, n_columns = ground.elevation_m.shape
        shade = hillshade(ground.elevation_m, ground.cell_m)
        picture = base64.b64encode(shade).decode("ascii")
        places["images"] = [
            {
                "source": f"data:image/png;base64,{picture}",
                "xref": "x",
                "yref": "y",
                "x": ground.west_m,
                "y": ground.north_m,
                "sizex": n_columns * ground.cell_m,
                "sizey": n_rows * ground.cell_m,
                "sizing": "stretch",
                "layer": "below",
                "opacity": 0.85,
            }
        ]
    return places


def _ticks(degrees: bool) -> str:
    return ".3f" if degrees else "d"


def _span(values: Floats) -> tuple[float, float]:
    return float(np.min(values)), float(np.max(values))


def _runout(plan: PlanView, row: Any, color: str, width: float) -> list[Trace]:
    """The 90 % of a row along the line, and its median; rows lie on each other, narrower.

    Of the design runout; of avalanches of the volume where the row is for one.
    """
    spread = (row.get("design") or row)["runout_x_m"]
    name = f"design runout, {case(row)}" if row.get("design") else f"avalanches of {case(row)}"
    if spread["q05"] is None:
        return []
    end = float(plan.x[-1]) if spread["q95"] is None else float(spread["q95"])
    east, north = _along(plan, float(spread["q05"]), end)
    group = f"row {case(row)}"
    traces: list[Trace] = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": name,
            "legendgroup": group,
            "x": east,
            "y": north,
            "line": {"color": color, "width": max(width, 3.0)},
            "opacity": 0.65,
            "text": [f"{name}: x {interval(spread)}"] * BAR_PLACES,
            "hovertemplate": "%{text}<extra></extra>",
        }
    ]
    if spread["q50"] is not None:
        east, north = _at(plan, np.array([spread["q50"]], dtype=np.float64))
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "legendgroup": group,
                "showlegend": False,
                "x": east,
                "y": north,
                "marker": {"symbol": "diamond", "size": 10, "color": color,
                           "line": {"color": "white", "width": 1}},
                "hovertemplate": f"{name}, median: x {spread['q50']:.0f} m<extra></extra>",
            }
        )  # fmt: skip
    return traces


def _along(plan: PlanView, start: float, end: float) -> tuple[Floats, Floats]:
    return _at(plan, np.linspace(start, end, BAR_PLACES))


def _at(plan: PlanView, x: Floats) -> tuple[Floats, Floats]:
    return np.interp(x, plan.x, plan.east), np.interp(x, plan.x, plan.north)


def _caption(plan: PlanView) -> str:
    words = (
        "Coordinates are longitude and latitude."
        if plan.crs is None
        else f"Coordinates are those of {plan.crs}."
    )
    shade = " The shading is that of the terrain model of the import." if plan.ground else ""
    return (
        f"{words} The coloured line holds 90 % of what the design runout may be, the diamond is "
        f"its median; for a given volume, of its avalanches.{shade}"
    )
