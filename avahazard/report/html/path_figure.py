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
from avahazard.report.language import ENGLISH, Language

MARGIN = {"l": 92, "r": TOOLBAR_PX, "t": 10, "b": 50}
ROOM = 1.15
PROFILE_PX, PANEL_PX, GAP_PX = 340, 140, 32


def path_figure(
    k: int,
    view: PathView,
    loop: LoopView,
    all_events: Sequence[EventView],
    language: Language = ENGLISH,
) -> Figure | None:
    """Panels above one another over the same x; None for a path without a profile.

    The last trace of the profile is the block, which the page's sliders move.
    """
    if view.smooth is None or view.release_x is None:
        return None
    say = language.say
    shown = stops_of(view, loop, all_events)
    bands = [float(np.max(state.x[shown, 2])) for state in loop.models if shown]
    end = shown_end(view, bands)
    here = [place for place in loop.places if place.path_id == view.path.path_id]
    ground = [
        *profile_traces(view, language),
        *place_traces(here, view.smooth, end, language),
        block_trace(view, language),
    ]
    panels: list[tuple[list[Trace], dict[str, Any], int]] = [
        (
            ground,
            axis(say("elevation (m)"), range=profile_range(view.smooth, len(view.rows))),
            PROFILE_PX,
        )
    ]
    words = [say("its profile with the recorded stops and the predicted runouts")]
    states: States = {}
    if shown:
        words.append(say("every record beside where it was expected"))
        traces, changes = stops_traces(view, loop, all_events, shown, language)
        states = {
            key: {len(ground) + number: trace for number, trace in change.items()}
            for key, change in changes.items()
        }
        rows = axis(say("records"), range=[0.0, len(shown) + 1.0], showticklabels=False)
        panels.append((traces, {**rows, "ticks": "", "showgrid": False}, stops_height(len(shown))))
    speeds = speed_traces(view, language)
    if speeds:
        words.append(say("the speeds"))
        panels.append((speeds, axis(say("speed (m/s)"), rangemode="tozero"), PANEL_PX))
    if reach_of(view) is not None:
        words.append(say("the chance to be reached in a year"))
        ticks = [1.0, 0.1, 0.01, 0.001, 0.0001]
        panels.append(
            (
                reach_traces(view, language),
                axis(
                    say("reached a year"),
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
        say("distance along the path x (m)"),
        anchor=last,
        range=[view.smooth.x_min, end],
    )
    places = layout(x_axis, axes.pop("yaxis"), height=total + 130, margin=MARGIN, **axes)
    return Figure(
        f"path-{k}",
        say("Along the path"),
        say("{path}, along the path: {parts}.", path=view.name, parts=", ".join(words)),
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


def block_trace(view: PathView, language: Language = ENGLISH) -> Trace:
    """The block, on its release until a slider moves it."""
    assert view.smooth is not None
    return {
        "type": "scatter",
        "mode": "markers",
        "name": language.say("the block"),
        "meta": "block",
        "showlegend": False,
        "cliponaxis": False,
        "x": [view.release_x],
        "y": [float(view.smooth.height(view.release_x or 0.0))],
        "visible": False,
        "marker": {"symbol": "square", "size": 15, "color": VERMILION,
                   "line": {"color": "white", "width": 2}},
        "hovertemplate": language.say(
            "the block stops: x {x} m, {y} m", x="%{x:.0f}", y="%{y:.0f}"
        )
        + "<extra></extra>",
    }  # fmt: skip
