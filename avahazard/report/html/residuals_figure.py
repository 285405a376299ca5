"""What the model misses, record by record, over the volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.report.html.content import EventView, LoopView
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.style import BLACK, axis, by_path, layout
from avahazard.report.html.words import event_words
from avahazard.report.language import ENGLISH, Language
from avahazard.results.amounts import RATIO

ROOM = 1.08


def residuals_figure(
    events: Sequence[EventView],
    names: dict[str, str],
    loop: LoopView,
    language: Language = ENGLISH,
) -> Figure | None:
    """Predicted mean less record of every event with a volume; None where there are none."""
    say = language.say
    states = (*loop.models, *loop.swept)
    own = next((s for s in loop.models if s.key == loop.lineage[-1]), None)
    with_volume = [e for e in events if e.volume_m3 is not None]
    if own is None or not with_volume:
        return None
    place = {e.event_id: k for k, e in enumerate(events)}
    ratio = {e.coordinate for e in events} == {RATIO}
    shape = "%{y:.4f}" if ratio else "%{y:.0f} m"
    data: list[Trace] = []
    changes: dict[str, dict[int, Trace]] = {state.key: {} for state in states}
    for name, color, symbol, mine in by_path(with_volume, names, language):
        rows = [place[e.event_id] for e in mine]
        for state in states:
            changes[state.key][len(data)] = {"y": state.error[rows]}
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": label(name),
                "x": [e.volume_m3 for e in mine],
                "y": own.error[rows],
                "marker": {"color": color, "symbol": symbol, "size": 7},
                "opacity": 0.8,
                "text": [label(event_words(e, names, language)) for e in mine],
                "hovertemplate": "%{text}<br>"
                + say("predicted less recorded: {error}", error=shape)
                + "<extra></extra>",
            }
        )
    most = ROOM * max(float(np.nanmax(np.abs(state.error))) for state in states)
    line = {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 0, "y1": 0}
    lost = len(events) - len(with_volume)
    places = layout(
        axis(say("volume (m³)"), type="log", dtick=1),
        axis(
            say("predicted less recorded ({unit})", unit="H/L" if ratio else "m"),
            range=[-most, most],
        ),
        height=420,
        shapes=[{**line, "line": {"color": BLACK, "width": 1, "dash": "dash"}}],
    )
    return Figure(
        "residuals",
        say("What the model misses"),
        say("Predicted mean less record of {n} events over their volume.", n=len(with_volume)),
        say(
            "Each mark is an event: the mean of what the model expects less the record, in the "
            "unit of what was recorded. A model that lacks nothing scatters evenly about the "
            "dashed line."
        )
        + (
            " "
            + language.plural(
                "{n} event without a volume is left out.",
                "{n} events without a volume are left out.",
                lost,
            )
            if lost
            else ""
        ),
        data,
        places,
        states=changes,
    )
