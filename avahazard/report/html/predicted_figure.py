"""Every record against what the model predicts for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from avahazard.report.html.content import EventView, LoopView, StateView
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.style import BLACK, axis, by_path, layout
from avahazard.report.html.words import event_words
from avahazard.report.language import ENGLISH, Language
from avahazard.results.amounts import RATIO

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
