"""Every record against what the model predicts for it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from avahazard.report.html.content import EventView, LoopView, PathView, StateView
from avahazard.report.html.figure import (
    BLACK,
    BLUE,
    ORANGE,
    VERMILION,
    Figure,
    Trace,
    axis,
    by_path,
    label,
    layout,
)
from avahazard.report.language import ENGLISH, Language
from avahazard.report.words import event_words
from avahazard.results.base import RATIO

KINDS = ("elevation", "x", "length", RATIO)


def predicted_figures(
    events: Sequence[EventView],
    names: dict[str, str],
    loop: LoopView,
    language: Language = ENGLISH,
) -> list[Figure]:
    """A figure for each coordinate that was recorded: elevation, x, runout length.

    The states of the loop are those that the page's switch can show.
    """
    states = (*loop.models, *loop.swept)
    place = {e.event_id: k for k, e in enumerate(events)}
    figures = []
    for coordinate in KINDS:
        mine = [e for e in events if e.coordinate == coordinate and e.predicted is not None]
        if mine:
            figures.append(_figure(coordinate, mine, names, states, place, language))
    return figures


def _figure(
    coordinate: str,
    events: list[EventView],
    names: dict[str, str],
    states: Sequence[StateView],
    place: Mapping[str, int],
    language: Language,
) -> Figure:
    say = language.say
    titles, predicted, recorded = _titles(coordinate, language)
    unit = "" if coordinate == RATIO else " m"
    of = ".4g" if coordinate == RATIO else ".0f"
    stopped = [e for e in events if e.observed_m is not None]
    data: list[Trace] = []
    changes: dict[str, dict[int, Trace]] = {state.key: {} for state in states}
    for name, color, symbol, mine in by_path(stopped, names, language):
        rows = [place[e.event_id] for e in mine]
        for state in states:
            low, middle, high = state.predicted[rows].T
            bars = {"error_x.array": high - middle, "error_x.arrayminus": middle - low}
            changes[state.key][len(data)] = {"x": middle, **bars}
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
                "text": [label(event_words(e, names, language)) for e in mine],
                "hovertemplate": "%{text}<br>"
                + say(
                    "predicted {predicted}, recorded {recorded}",
                    predicted=f"%{{x:{of}}}{unit}",
                    recorded=f"%{{y:{of}}}{unit}",
                )
                + "<extra></extra>",
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
                "name": say("predicted = recorded"),
                "x": line,
                "y": line,
                "line": {"color": BLACK, "width": 1, "dash": "dash"},
                "hoverinfo": "skip",
            }
        )
    left = len(events) - len(stopped)
    return Figure(
        f"predicted-{coordinate}",
        titles,
        say(
            "{title}, of {n} events; {inside} of the records lie in their 90 % interval.",
            title=titles,
            n=len(stopped),
            inside=inside,
        ),
        say(
            "Each mark is an event: the predicted median across, the record upwards; the bar "
            "holds 90 % of what the model expects to be recorded. {inside} of {n} records lie "
            "within their bar. These records were used in the calibration.",
            n=len(stopped),
            inside=inside,
        )
        + (
            " "
            + language.plural(
                "{n} event that left its profile has no stop to show.",
                "{n} events that left their profile have no stop to show.",
                left,
            )
            if left
            else ""
        ),
        data,
        layout(axis(predicted, **_range(stopped, states, place)), axis(recorded), height=520),
        states=changes,
    )  # fmt: skip


def _titles(coordinate: str, language: Language) -> tuple[str, str, str]:
    """Title of the figure, and of the axes of what was predicted and recorded."""
    say = language.say
    return {
        "elevation": (
            say("Elevations of the stops: measured against predicted"),
            say("predicted elevation of the stop (m)"),
            say("recorded elevation of the stop (m)"),
        ),
        "x": (
            say("Places of the stops along the path: measured against predicted"),
            say("predicted distance x of the stop (m)"),
            say("recorded distance x of the stop (m)"),
        ),
        "length": (
            say("Runout lengths: measured against predicted"),
            say("predicted runout length (m)"),
            say("recorded runout length (m)"),
        ),
        RATIO: (
            say("H over L: measured against predicted"),
            say("predicted H/L"),
            say("recorded H/L"),
        ),
    }[coordinate]


def _range(
    events: Sequence[EventView], states: Sequence[StateView], place: Mapping[str, int]
) -> dict[str, list[float]]:
    """One range for all states, so that it is the marks that move."""
    if not states or not events:
        return {}
    rows = [place[e.event_id] for e in events]
    values = np.concatenate([state.predicted[rows].ravel() for state in states])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return {"range": [low - 0.03 * (high - low), high + 0.03 * (high - low)]}


def _inside(event: EventView) -> bool:
    if event.predicted is None or event.observed_m is None:
        return False
    return event.predicted[0] <= event.observed_m <= event.predicted[2]


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
