"""A path seen from above: its line, the recorded stops and the runouts."""

import base64
import math
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.records.collection import TerrainCrop
from avahazard.report.html import figure as fig
from avahazard.report.html.content import FlowView, PathView, PlanView
from avahazard.report.html.figure import Figure, Trace
from avahazard.report.language import say, spoken
from avahazard.report.words import case, metres
from avahazard.results.hazard import HazardRow
from avahazard.results.terrain import PERIOD_COLORS

Span = tuple[float, float]

M_PER_DEGREE = 111_320.0
"""Of latitude; of longitude at the equator."""
SHARE, INSET, TICK = 0.3, 0.04, 0.012
"""Most of the width that the bar takes, its distance from the edges, the height of its ends."""


def scale_bar(east: Span, north: Span, degrees: bool, *, right: bool = False) -> Trace:
    """A bar of a round length (m) in the lower left, or `right`, corner of what is shown."""
    middle = math.radians(0.5 * (north[0] + north[1]))
    unit = 1.0 / (M_PER_DEGREE * math.cos(middle)) if degrees else 1.0
    length = round_length(SHARE * (east[1] - east[0]) / unit)
    wide, high = east[1] - east[0], north[1] - north[0]
    x0, y0 = east[0] + INSET * wide, north[0] + INSET * high
    if right:
        x0 = east[1] - INSET * wide - length * unit
    x1, up = x0 + length * unit, TICK * high
    return fig.line(
        [x0, x0, x0, 0.5 * (x0 + x1), x1, x1, x1],
        [y0, y0 - up, y0, y0, y0, y0, y0 - up],
        fig.INK,
        2.0,
        mode="lines+text",
        meta="scale",
        showlegend=False,
        text=["", "", "", metres(length), "", "", ""],
        textposition="top center",
    )


def round_length(most: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is not over `most`."""
    power = 10.0 ** math.floor(math.log10(most))
    return next(k * power for k in (5.0, 2.0, 1.0) if k * power <= most)


NORTH_ARROW = {
    "xref": "paper", "yref": "paper", "x": 0.97, "y": 0.98, "ax": 0, "ay": 34, "text": "<b>N</b>",
    "showarrow": True, "arrowhead": 2, "arrowwidth": 2, "arrowcolor": fig.INK, "yanchor": "top",
}  # fmt: skip
"""An arrow to the top of the map, which is north."""

TO_LIGHT = np.array([-0.5, 0.5, np.sqrt(0.5)])
"""East, north, up: from the north-west, 45° high."""
DARKEST = 0.35


MOST_SHADED = 200
"""Cells of the picture along a side, at most."""
TINT = 0.55


def terrain_png(ground: TerrainCrop, flow: FlowView | None) -> str:
    """The ground of a path with the areas that flow comes to, as the address of a picture."""
    step = -(-max(ground.elevation_m.shape) // MOST_SHADED)
    chance = None if flow is None else flow.chance[::step, ::step]
    shade = hillshade(ground.elevation_m[::step, ::step], step * ground.cell_m, chance)
    return f"data:image/png;base64,{base64.b64encode(shade).decode('ascii')}"


def hillshade(
    elevation_m: NDArray[np.float32], cell_m: float, chance: Floats | None = None
) -> bytes:
    """PNG of elevations `[n_rows, n_columns]`, rows from north; clear where they are NaN.

    Grey is the cosine of the angle between the normal of the ground and the light (Lambert). Where
    the annual `chance` is over 1/T it has the colour of the shortest such period T.
    """
    from matplotlib.colors import to_rgb  # noqa: PLC0415 (slow)
    from matplotlib.image import imsave  # noqa: PLC0415 (slow)

    ground = elevation_m.astype(np.float64)
    southward, eastward = np.gradient(ground, cell_m)
    normal = np.stack([-eastward, southward, np.ones_like(ground)])
    light = np.tensordot(TO_LIGHT, normal, 1) / np.linalg.norm(normal, axis=0)
    shade = DARKEST + (1.0 - DARKEST) * np.clip(light, 0.0, 1.0)
    known = np.isfinite(shade) & np.isfinite(ground)
    colored = np.dstack([np.where(known, np.round(shade, 2), 0.0)] * 3 + [known.astype(float)])
    often = np.zeros_like(ground) if chance is None else chance
    for period, color in PERIOD_COLORS.items():
        inside = (often >= 1.0 / period) & known
        colored[inside, :3] = TINT * np.array(to_rgb(color)) + (1.0 - TINT) * shade[inside, None]
    picture = BytesIO()
    # Nothing of the day or of the machine: equal grounds make equal pictures.
    imsave(picture, colored, metadata={"Software": ""}, format="png")
    return picture.getvalue()


EDGE = 0.08
"""Room around what is drawn, as a share of its size."""


def map_figure(k: int, view: PathView) -> Figure | None:
    """The plan of a path; None where it has no coordinates."""
    plan = view.plan
    if plan is None or view.smooth is None or view.release_x is None:
        return None
    degrees = plan.crs is None
    data: list[Trace] = [fig.line(plan.east, plan.north, fig.INK, 1.6, name=say("path"))]
    for period, color in PERIOD_COLORS.items() if plan.flow else ():
        look = {"symbol": "square", "size": 14, "color": color, "opacity": TINT}
        data.append(fig.marks([None], [None], look, name=period_text(period)))
    for zone in view.drawn_zones:
        name = fig.label(say("zone: {zone}", zone=say(zone.zone)))
        ends = plan.at(np.linspace(zone.from_x_m, zone.to_x_m, fig.BAR_PLACES))
        data.append(fig.line(*ends, zone.color, 12.0, "%{fullData.name}", name=name, opacity=0.5))
    for number, row in enumerate(view.rows[: len(fig.ROW_COLORS)]):
        data += _runout(plan, row, fig.ROW_COLORS[number], 9.0 - 1.5 * number)
    stops = [e for e in view.events if e.stop_x_m is not None]
    if stops:
        names = {view.path.path_id: view.name}
        look = {"symbol": "circle-open", "size": 7, "color": fig.INK, "line": {"width": 1.2}}
        there = plan.at([e.stop_x_m for e in stops])
        data.append(fig.event_marks(*there, look, stops, names, name=say("recorded stops")))
    look = {"symbol": "triangle-down", "size": 11, "color": fig.BLACK}
    data.append(fig.marks(*plan.at([view.release_x]), look, say("release"), name=say("release")))
    east, north, ratio = _ranges(plan)
    lowest = plan.east[np.argmin(plan.north)]
    data.append(scale_bar(east, north, degrees, right=bool(lowest < 0.5 * (east[0] + east[1]))))
    whole = _layout(plan, east, north, ratio)
    return Figure(f"map-{k}", say("Seen from above"), data, whole, digits=9)


def period_text(period: float) -> str:
    """What the colour of a return period (years) says."""
    return fig.label(say("comes here once in {years} years", years=spoken().number(f"{period:g}")))


def _layout(plan: PlanView, east: Span, north: Span, ratio: float) -> dict[str, Any]:
    across, upwards, ticks = say("easting (m)"), say("northing (m)"), "d"
    if plan.crs is None:
        across, upwards, ticks = say("longitude (°)"), say("latitude (°)"), ".3f"
    places = fig.layout(
        fig.axis(across, nticks=5, tickformat=ticks, range=list(east)),
        fig.axis(upwards, nticks=6, tickformat=ticks, range=list(north),
             scaleanchor="x", scaleratio=ratio),
        height=520,
        margin=fig.WIDE_MARGIN,
        annotations=[NORTH_ARROW],
    )  # fmt: skip
    if plan.ground is not None:
        ground = plan.ground
        n_rows, n_columns = ground.elevation_m.shape
        places["images"] = [
            {"source": terrain_png(ground, plan.flow), "xref": "x", "yref": "y",
             "x": ground.west_m, "y": ground.north_m, "sizex": n_columns * ground.cell_m,
             "sizey": n_rows * ground.cell_m, "sizing": "stretch", "layer": "below",
             "opacity": 0.85}
        ]  # fmt: skip
    return places


def _ranges(plan: PlanView) -> tuple[Span, Span, float]:
    """What is shown from west to east and from south to north, and the ratio of their units."""
    east, north = ((float(np.min(v)), float(np.max(v))) for v in (plan.east, plan.north))
    ratio = 1.0 / math.cos(math.radians(float(np.mean(plan.north)))) if plan.crs is None else 1.0
    room = EDGE * max(east[1] - east[0], (north[1] - north[0]) * ratio)
    up = room / ratio
    return (east[0] - room, east[1] + room), (north[0] - up, north[1] + up), ratio


def _runout(plan: PlanView, row: HazardRow, color: str, width: float) -> list[Trace]:
    """The 90 % of a row along the line, and its median; rows lie on each other, narrower.

    Of the design runout; of avalanches of the volume where the row is for one.
    """
    of, found = case(row), (row.design or row).runout_x_m
    name = say("avalanches of {volume}", volume=of)
    if row.design:
        name = say("design runout, {case}", case=of)
    own = {"color": color, "width": max(width, 3.0), "legendgroup": f"row {of}", "opacity": 0.65}
    look = {"symbol": "diamond", "size": 10, "color": color, "line": {"color": "white", "width": 1}}
    return fig.runout_bar(plan.at, found, float(plan.x[-1]), name, own, look)
