"""The recorded stops of a path beside where a model expects them, record by record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.html.content import EventView, LoopView, PathView, StateView
from avahazard.report.html.figure import Trace, label
from avahazard.report.html.style import BLUE, INK
from avahazard.report.html.words import event_words
from avahazard.report.language import ENGLISH, Language

BEFORE, ROW_PX, LEAST_PX, MOST_PX = "#BDBDBD", 7, 70, 260


def stops_of(view: PathView, loop: LoopView, events: Sequence[EventView]) -> list[int]:
    """Which of all events are shown: those of the path with a place, by volume, smallest first."""
    if not loop.models:
        return []
    known = [
        k
        for k, e in enumerate(events)
        if e.path_id == view.path.path_id
        and e.stop_x_m is not None
        and np.isfinite(loop.models[0].x[k]).all()
    ]
    return sorted(known, key=lambda k: events[k].volume_m3 or 0.0)


def stops_height(n: int) -> int:
    """Pixels for so many records."""
    return int(np.clip(ROW_PX * n, LEAST_PX, MOST_PX))


def stops_traces(
    view: PathView,
    loop: LoopView,
    events: Sequence[EventView],
    shown: Sequence[int],
    language: Language = ENGLISH,
) -> tuple[list[Trace], dict[str, Mapping[int, Trace]]]:
    """Bands of the parent and of the model, the medians, the records; and what states change.

    A band holds 90 % of where the block of that record is expected to stop.
    """
    say = language.say
    states = {state.key: state for state in (*loop.models, *loop.swept)}
    name = loop.lineage[-1]
    parent = loop.lineage[-2] if len(loop.lineage) > 1 and loop.lineage[-2] in states else None
    rows = np.arange(1.0, len(shown) + 1.0)
    names = {view.path.path_id: view.name}
    traces: list[Trace] = []
    if parent is not None:
        before = say("90 % by “{model}”", model=parent)
        traces.append(_bands(states[parent], shown, rows, before, BEFORE, 5.0))
    band = len(traces)
    now = say("90 % of the model shown")
    traces.append(_bands(states[name], shown, rows, now, BLUE, 2.4))
    traces.append(
        {
            "type": "scatter",
            "mode": "markers",
            "showlegend": False,
            "x": states[name].x[shown, 1],
            "y": rows,
            "marker": {"color": BLUE, "size": 4},
            "hovertemplate": say("median of the model shown: x {x} m", x="%{x:.0f}")
            + "<extra></extra>",
        }
    )
    traces.append(
        {
            "type": "scatter",
            "mode": "markers",
            "showlegend": False,
            "x": [events[k].stop_x_m for k in shown],
            "y": rows,
            "marker": {"symbol": "line-ns-open", "size": 8, "color": INK,
                       "line": {"width": 1.6, "color": INK}},
            "text": [label(event_words(events[k], names, language)) for k in shown],
            "hovertemplate": "%{text}<br>"
            + say("stopped at x {x} m", x="%{x:.0f}")
            + "<extra></extra>",
        }
    )  # fmt: skip
    changes: dict[str, Mapping[int, Trace]] = {
        key: {band: {"x": _ends(state, shown)}, band + 1: {"x": state.x[shown, 1]}}
        for key, state in states.items()
    }
    return traces, changes


def _bands(
    state: StateView, shown: Sequence[int], rows: Floats, name: str, color: str, width: float
) -> Trace:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": label(name),
        "x": _ends(state, shown),
        "y": [v for row in rows.tolist() for v in (row, row, None)],
        "line": {"color": color, "width": width},
        "hoverinfo": "skip",
    }


def _ends(state: StateView, shown: Sequence[int]) -> list[float | None]:
    """Both ends of every band, and a gap after it."""
    return [v for k in shown for v in (float(state.x[k, 0]), float(state.x[k, 2]), None)]
