"""The record through the years: a mark for every event, path by path."""

from __future__ import annotations

import math
from collections.abc import Sequence

from avahazard.report.html.content import EventView, PathView
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.style import BLUE, ORANGE, VERMILION, axis, layout
from avahazard.report.html.words import event_words
from avahazard.report.language import ENGLISH, Language

ROW_PX = 24


def record_figure(
    events: Sequence[EventView], paths: Sequence[PathView], language: Language = ENGLISH
) -> Figure | None:
    """Dated events by year and path, larger where the volume was; None where none is dated."""
    say = language.say
    names = {view.path.path_id: view.name for view in paths}
    dated = [e for e in events if e.year is not None]
    if not dated:
        return None
    rows = list(dict.fromkeys(_row(e, names, language) for e in dated))
    rows += [label(view.name) for view in paths if label(view.name) not in rows]
    kinds = (
        (
            say("stopped on the profile"),
            BLUE,
            "circle",
            [e for e in dated if not e.left_profile],
        ),
        (
            say("left the profile"),
            VERMILION,
            "diamond-open",
            [e for e in dated if e.left_profile],
        ),
    )
    data: list[Trace] = [
        {
            "type": "scatter",
            "mode": "markers",
            "name": name,
            "x": [e.year for e in mine],
            "y": [_row(e, names, language) for e in mine],
            "text": [label(event_words(e, names, language)) for e in mine],
            "hovertemplate": "%{text}<extra></extra>",
            "marker": {
                "color": color,
                "symbol": symbol,
                "opacity": 0.65,
                "size": [_size(e.volume_m3) for e in mine],
            },
        }
        for name, color, symbol, mine in kinds
        if mine
    ]
    spans = [
        (label(v.name), v.path.observed_from, v.path.observed_to)
        for v in paths
        if v.path.observed_from is not None and v.path.observed_to is not None
    ]
    if spans:
        data.insert(
            0,
            {
                "type": "scatter",
                "mode": "lines",
                "name": say("observed years"),
                "x": [x for _, first, last in spans for x in (first, last, None)],
                "y": [y for name, _, _ in spans for y in (name, name, None)],
                "line": {"color": ORANGE, "width": 2},
                "opacity": 0.6,
                "hoverinfo": "skip",
            },
        )
    undated = len(events) - len(dated)
    return Figure(
        "record",
        say("The record through the years"),
        say(
            "Dated events ({n}) by year, a row for each path ({paths}); the mark grows with the "
            "volume.",
            n=len(dated),
            paths=len(rows),
        ),
        say(
            "Each mark is an event; larger marks are larger volumes. Empty stretches are years "
            "without events, or years in which nobody looked."
        )
        + (
            " "
            + language.plural(
                "{n} event without a date is not shown.",
                "{n} events without a date are not shown.",
                undated,
            )
            if undated
            else ""
        ),
        data,
        layout(
            axis(say("year")),
            axis("", type="category", categoryarray=rows[::-1], tickfont={"size": 11}),
            height=130 + ROW_PX * len(rows),
        ),
    )


def _row(event: EventView, names: dict[str, str], language: Language) -> str:
    if event.path_id is None:
        return language.say("no path")
    return label(names.get(event.path_id, event.path_id))


def _size(volume_m3: float | None) -> float:
    """Diameter in pixels: 5 at 1,000 m3 and less, 3 more for each factor of 10."""
    return 6.0 if not volume_m3 else 5.0 + 3.0 * max(0.0, math.log10(volume_m3) - 3.0)
