"""One path along its length: the profile with its runouts, the speeds, the chance to be reached."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from avahazard.report.html.content import EventView, LoopView, PathView
from avahazard.report.html.figure import Figure, States, Trace
from avahazard.report.html.place_traces import place_traces
from avahazard.report.html.profile_panel import profile_range, profile_traces
from avahazard.report.html.reach_panel import reach_of, reach_traces
from avahazard.report.html.speed_panel import speed_traces
from avahazard.report.html.stops_panel import stops_height, stops_of, stops_traces
from avahazard.report.html.style import TOOLBAR_PX, VERMILION, axis, layout

MARGIN = {"l": 92, "r": TOOLBAR_PX, "t": 10, "b": 50}
ROOM = 1.15
PROFILE_PX, PANEL_PX, GAP_PX = 340, 140, 32


def path_figure(
    k: int, view: PathView, loop: LoopView, all_events: Sequence[EventView]
) -> Figure | None:
    """Panels above one another over the same x; None for a path without a profile.

    The last trace of the profile is the block, which the page's sliders move.
    """
    if view.smooth is None or view.release_x is None:
        return None
    shown = stops_of(view, loop, all_events)
    bands = [float(np.max(state.x[shown, 2])) for state in loop.models if shown]
    end = shown_end(view, bands)
    here = [place for place in loop.places if place.path_id == view.path.path_id]
    ground = [*profile_traces(view), *place_traces(here, view.smooth, end), block_trace(view)]
    panels: list[tuple[list[Trace], dict[str, Any], int]] = [
        (
            ground,
            axis("elevation (m)", range=profile_range(view.smooth, len(view.rows))),
            PROFILE_PX,
        )
    ]
    words = ["its profile with the recorded stops and the predicted runouts"]
    states: States = {}
    if shown:
        words.append("every record beside where it was expected")
        traces, changes = stops_traces(view, loop, all_events, shown)
        states = {
            key: {len(ground) + number: trace for number, trace in change.items()}
            for key, change in changes.items()
        }
        rows = axis("records", range=[0.0, len(shown) + 1.0], showticklabels=False)
        panels.append((traces, {**rows, "ticks": "", "showgrid": False}, stops_height(len(shown))))
    speeds = speed_traces(view)
    if speeds:
        words.append("the speeds")
        panels.append((speeds, axis("speed (m/s)", rangemode="tozero"), PANEL_PX))
    if reach_of(view) is not None:
        words.append("the chance to be reached in a year")
        ticks = [1.0, 0.1, 0.01, 0.001, 0.0001]
        panels.append(
            (
                reach_traces(view),
                axis(
                    "reached a year",
                    type="log",
                    tickvals=ticks,
                    ticktext=["1", "1/10", "1/100", "1/1000", "1/10 000"],
                    range=[-4.0, 0.15],
                ),
                PANEL_PX,
            )
        )
    total = sum(px for _, _, px in panels) + GAP_PX * (len(panels) - 1)
    data: list[Trace] = []
    axes: dict[str, Any] = {}
    top = float(total)
    for number, (traces, y_axis, px) in enumerate(panels, start=1):
        name = "" if number == 1 else str(number)
        data += [{**trace, "yaxis": f"y{name}"} for trace in traces]
        axes[f"yaxis{name}"] = {**y_axis, "domain": [(top - px) / total, top / total]}
        top -= px + GAP_PX
    last = "y" if len(panels) == 1 else f"y{len(panels)}"
    x_axis = axis(
        "distance along the path x (m)",
        anchor=last,
        range=[view.smooth.x_min, end],
    )
    places = layout(x_axis, axes.pop("yaxis"), height=total + 130, margin=MARGIN, **axes)
    return Figure(
        f"path-{k}",
        "Along the path",
        f"{view.name}: {', '.join(words)}, along the path.",
        "",
        data,
        places,
        states=states,
    )


def shown_end(view: PathView, more: Sequence[float] = ()) -> float:
    """x (m) to which the path is drawn: a little past all that is shown there, and `more`."""
    smooth = view.smooth
    assert smooth is not None
    found = [row["design"]["runout_x_m"] for row in view.rows if row.get("design")]
    found += [row["runout_x_m"] for row in view.rows]
    ends = [place[key] for place in found for key in ("q50", "q95")]
    ends += [row["runout_x_m"] for row in view.alpha_beta if row["runout_x_m"] is not None]
    ends += more
    stops = [e.stop_x_m for e in view.events if e.stop_x_m is not None]
    if (not ends and not stops) or None in ends:
        return smooth.x_max
    length = ROOM * (max([*ends, *stops]) - smooth.x_min)
    return float(min(smooth.x_min + length, smooth.x_max))


def block_trace(view: PathView) -> Trace:
    """The block, on its release until a slider moves it."""
    assert view.smooth is not None
    return {
        "type": "scatter",
        "mode": "markers",
        "name": "the block",
        "showlegend": False,
        "cliponaxis": False,
        "x": [view.release_x],
        "y": [float(view.smooth.height(view.release_x or 0.0))],
        "visible": False,
        "marker": {"symbol": "square", "size": 15, "color": VERMILION,
                   "line": {"color": "white", "width": 2}},
        "hovertemplate": "the block stops: x %{x:.0f} m, %{y:.0f} m<extra></extra>",
    }  # fmt: skip


def reading_words(views: Sequence[PathView], *, stops: bool = False) -> list[str]:
    """How to read the figures of the paths: of what they hold, once for all."""
    rows = [row for view in views for row in view.rows]
    words = []
    if any(row.get("design") for row in rows):
        words.append(
            "Thick bars above the ground hold 90 % of what the runout exceeded once in the return "
            "period may be; the tick is its median."
        )
    if rows:
        words.append(
            "Thin lines hold 90 % of avalanches of one volume (that of the return period, or a "
            "given one), and the humps on them are their distribution; the small tick is their "
            "median. A bar that ends at the edge goes on beyond the profile."
        )
    if stops:
        words.append(
            "Under the profile every record has a line: the tick is where it stopped, the bar "
            "holds 90 % of where the model shown expects it, the grey one behind it that of the "
            "parent, if it has one."
        )
    if any(view.alpha_beta for view in views):
        words.append(
            "Stars: the α-β runout, from the shape of the ground alone, with one standard "
            "deviation."
        )
    if any(view.zones for view in views):
        words.append(
            "The strip at the foot shows the zones. Speeds are those that a year exceeds with "
            "chance 1/T: the median full, 95 % dashed, 5 % dotted; hover for the pressure."
        )
    elif any(view.speeds for view in views):
        words.append("Speeds are those of the block of median friction at that volume.")
    if any(row.get("reach") for row in rows):
        words.append(
            "The lowest panel gives the chance that an avalanche comes as far in a year, and 90 % "
            "of what that may be."
        )
    return words
