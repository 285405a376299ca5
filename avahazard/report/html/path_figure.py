"""One path along its length: the profile with its runouts, the speeds, the chance to be reached."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from avahazard.report.html.content import PathView
from avahazard.report.html.figure import Figure, Trace
from avahazard.report.html.profile_panel import profile_range, profile_traces
from avahazard.report.html.reach_panel import reach_of, reach_traces
from avahazard.report.html.speed_panel import speed_traces
from avahazard.report.html.style import axis, layout

MARGIN = {"l": 92, "r": 14, "t": 10, "b": 50}
PROFILE_PX, PANEL_PX, GAP_PX = 340, 140, 32


def path_figure(k: int, view: PathView) -> Figure | None:
    """Panels above one another over the same x; None for a path without a profile."""
    if view.smooth is None or view.release_x is None:
        return None
    panels: list[tuple[list[Trace], dict[str, Any], int]] = [
        (
            profile_traces(view),
            axis("elevation (m)", range=profile_range(view.smooth, len(view.rows))),
            PROFILE_PX,
        )
    ]
    words = ["its profile with the recorded stops and the predicted runouts"]
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
        "horizontal distance along the path x (m)",
        anchor=last,
        range=[view.smooth.x_min, view.smooth.x_max],
    )
    places = layout(x_axis, axes.pop("yaxis"), height=total + 130, margin=MARGIN, **axes)
    return Figure(
        f"path-{k}",
        "Along the path",
        f"{view.name}: {', '.join(words)}, along the path.",
        "",
        data,
        places,
    )


def reading_words(views: Sequence[PathView]) -> list[str]:
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
