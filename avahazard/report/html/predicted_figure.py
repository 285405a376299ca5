"""Every record against what the model predicts for it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.report.html.content import EventView
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.style import BLACK, axis, by_path, layout
from avahazard.report.html.words import event_words

WORDS = {
    "elevation": ("elevation of the stop", "Elevations of the stops"),
    "x": ("distance x of the stop", "Places of the stops along the path"),
    "length": ("runout length", "Runout lengths"),
}


def predicted_figures(events: Sequence[EventView], names: dict[str, str]) -> list[Figure]:
    """A figure for each coordinate that was recorded: elevation, x, runout length."""
    figures = []
    for coordinate in WORDS:
        mine = [e for e in events if e.coordinate == coordinate and e.predicted is not None]
        if mine:
            figures.append(_figure(coordinate, mine, names))
    return figures


def _figure(coordinate: str, events: list[EventView], names: dict[str, str]) -> Figure:
    what, title = WORDS[coordinate]
    stopped = [e for e in events if e.observed_m is not None]
    data: list[Trace] = []
    for name, color, symbol, mine in by_path(stopped, names):
        low, middle, high = np.array([e.predicted for e in mine]).T
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": label(name),
                "x": middle,
                "y": [e.observed_m for e in mine],
                "error_x": {
                    "type": "data",
                    "symmetric": False,
                    "array": high - middle,
                    "arrayminus": middle - low,
                    "color": color,
                    "thickness": 0.7,
                    "width": 0,
                },
                "marker": {"color": color, "symbol": symbol, "size": 7},
                "opacity": 0.8,
                "text": [label(event_words(e, names)) for e in mine],
                "hovertemplate": "%{text}<br>predicted %{x:.0f} m, recorded %{y:.0f} m"
                "<extra></extra>",
            }
        )
    inside = sum(_inside(e) for e in stopped)
    if stopped:
        ends = [e.observed_m for e in stopped] + [e.predicted[1] for e in stopped if e.predicted]
        line = [min(v for v in ends if v is not None), max(v for v in ends if v is not None)]
        data.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": "predicted = recorded",
                "x": line,
                "y": line,
                "line": {"color": BLACK, "width": 1, "dash": "dash"},
                "hoverinfo": "skip",
            }
        )
    left = len(events) - len(stopped)
    return Figure(
        f"predicted-{coordinate}",
        f"{title}: measured against predicted",
        f"Recorded {what} of {len(stopped)} events against the predicted one; {inside} of the "
        "records lie in their 90 % interval.",
        f"Each mark is an event: the predicted median across, the record upwards; the bar holds "
        f"90 % of what the model expects to be recorded. {inside} of {len(stopped)} records lie "
        "within their bar. These records were used in the calibration."
        + (f" {left} events that left their profile have no stop to show." if left else ""),
        data,
        layout(axis(f"predicted {what} (m)"), axis(f"recorded {what} (m)"), height=520),
    )


def _inside(event: EventView) -> bool:
    if event.predicted is None or event.observed_m is None:
        return False
    return event.predicted[0] <= event.observed_m <= event.predicted[2]
