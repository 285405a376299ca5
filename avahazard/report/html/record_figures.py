"""Every record against what the model predicts for it, and against what its effects explain."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from avahazard.arrays import Bools, Floats
from avahazard.report.html import figure as fig
from avahazard.report.html.content import EventView, LoopView, PathView, StateView
from avahazard.report.html.figure import Figure, Trace
from avahazard.report.language import say, spoken
from avahazard.report.words import NAMES, axis_text, shape_text
from avahazard.results.base import RATIO

KINDS = ("elevation", "x", "length", RATIO)
DASHED = {"color": fig.BLACK, "width": 1.0, "dash": "dash"}
Names = dict[str, str]


def predicted_figures(events: Sequence[EventView], names: Names, loop: LoopView) -> list[Figure]:
    """A figure for each coordinate that was recorded: elevation, x, runout length, H/L.

    The states of the loop are those that the page's switch can show.
    """
    known = [k for k, event in enumerate(events) if event.predicted]
    by_kind = {kind: [k for k in known if events[k].coordinate == kind] for kind in KINDS}
    return [
        _predicted(kind, events, rows, names, loop)
        for kind, rows in by_kind.items()
        # Beyond the profile there is no stop to show.
        if any(events[k].observed_m is not None for k in rows)
    ]


def _predicted(
    coordinate: str, events: Sequence[EventView], rows: list[int], names: Names, loop: LoopView
) -> Figure:
    title, predicted, recorded = _titles(coordinate)
    stopped = [k for k in rows if events[k].observed_m is not None]
    states = loop.models
    data: list[Trace] = []
    changes: dict[str, dict[int, Trace]] = {state.key: {} for state in states}
    for name, marker, members in fig.by_path(events, stopped, names):
        for state in states:
            low, middle, high = state.predicted[members].T
            bars = {"error_x.array": high - middle, "error_x.arrayminus": middle - low}
            changes[state.key][len(data)] = {"x": middle, **bars}
        selected = [events[k] for k in members]
        expected = np.array([e.predicted for e in selected])
        there = [e.observed_m for e in selected]
        data.append(_against(expected, there, selected, marker, names, name))
    observed = np.array([events[k].observed_m for k in stopped], np.float64)
    low, middle, high = np.array([events[k].predicted for k in stopped]).reshape(-1, 3).T
    if stopped:
        ends = np.concatenate([observed, middle])
        data.append(_equal(float(ends.min()), float(ends.max())))
    inside = int(np.sum((low <= observed) & (observed <= high)))
    counts = {"stopped": len(stopped), "inside": inside, "left": len(rows) - len(stopped)}
    across = fig.axis(predicted, **_range(stopped, states))
    places = fig.layout(across, fig.axis(recorded), height=520)
    return Figure(f"predicted-{coordinate}", title, data, places, counts=counts, states=changes)


def _against(
    expected: Floats,
    recorded: Sequence[float | None],
    events: Sequence[EventView],
    marker: dict[str, Any],
    names: Names,
    name: str,
) -> Trace:
    """Records upwards, their 5, 50 and 95 % `expected` `[n_events, 3]` across."""
    form = ".4g}" if events[0].coordinate == RATIO else ".0f} m"
    low, middle, high = expected.T
    values = {"predicted": "%{x:" + form, "recorded": "%{y:" + form}
    hover = say("predicted {predicted}, recorded {recorded}", **values)
    bar = fig.error_bar(low, middle, high, marker["color"], thickness=0.7, width=0)
    own = {"error_x": bar, "name": name, "opacity": 0.8}
    return fig.event_marks(middle, recorded, marker, events, names, hover, **own)


def _equal(low: float, high: float) -> Trace:
    ends, name = [low, high], say("predicted = recorded")
    return fig.line(ends, ends, fig.BLACK, 1.0, dash="dash", name=name)


def _titles(coordinate: str) -> Iterator[str]:
    """Title of the figure, and of the axes of what was predicted and recorded."""
    for of in ("against", "predicted", "recorded"):
        words = NAMES[of][coordinate]
        yield say(words)


def _range(rows: Sequence[int], states: Sequence[StateView]) -> dict[str, list[float]]:
    """One range for all states, so that it is the marks that move."""
    if not states or not rows:
        return {}
    values = np.concatenate([state.predicted[rows].ravel() for state in states])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return {"range": [low - 0.03 * (high - low), high + 0.03 * (high - low)]}


ROOM, BAND = 1.08, "rgba(230,159,0,0.25)"


def residuals_figure(events: Sequence[EventView], names: Names, loop: LoopView) -> Figure | None:
    """Predicted mean minus record of every event with a volume; None where there are none."""
    states = loop.models
    own = next((state for state in states if state.key == loop.lineage[-1]), None)
    with_volume = [k for k, event in enumerate(events) if event.volume_m3 is not None]
    if own is None or not with_volume:
        return None
    ratio = {e.coordinate for e in events} == {RATIO}
    hover = say("predicted minus recorded: {error}", error="%{y:.4f}" if ratio else "%{y:.0f} m")
    data: list[Trace] = []
    changes: dict[str, dict[int, Trace]] = {state.key: {} for state in states}
    for name, look, rows in fig.by_path(events, with_volume, names):
        for state in states:
            changes[state.key][len(data)] = {"y": state.error[rows]}
        selected = [events[k] for k in rows]
        x, more = [e.volume_m3 for e in selected], {"name": name, "opacity": 0.8}
        data.append(fig.event_marks(x, own.error[rows], look, selected, names, hover, **more))
    most = ROOM * max(float(np.nanmax(np.abs(state.error))) for state in states)
    upwards = say("predicted minus recorded ({unit})", unit="H/L" if ratio else "m")
    volumes = fig.axis(say("volume (m³)"), type="log", exponentformat="power", dtick=1)
    zero = {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 0, "y1": 0, "line": DASHED}
    places = fig.layout(volumes, fig.axis(upwards, range=[-most, most]), shapes=[zero])
    return Figure("residuals", say("What the model misses"), data, places, states=changes)


def failed_figure(events: Sequence[EventView], names: Names, loop: LoopView) -> Figure | None:
    """Recorded against predicted place by the model before the last step, failing levels in colour.

    Of a model without a parent, that model. None where no event has a place on a profile.
    """
    before = loop.before
    if before is None:
        return None
    there = np.all(np.isfinite(before.x), axis=1)
    known = [k for k, e in enumerate(events) if e.stop_x_m is not None and there[k]]
    if not known:
        return None
    data: list[Trace] = []
    for name, color, rows in _kinds(before, before.failed, known):
        selected, places = [events[k] for k in rows], [events[k].stop_x_m for k in rows]
        look = {"color": color, "size": 7}
        data.append(_against(before.x[rows], places, selected, look, names, name))
    _, across, upwards = _titles("x")
    ends = [v for k in known for v in (events[k].stop_x_m, before.x[k, 1]) if v is not None]
    data.append(_equal(min(ends), max(ends)))
    title = say("Where “{model}” failed: recorded against predicted", model=before.key)
    whole = fig.layout(fig.axis(across), fig.axis(upwards), height=460)
    return Figure("failed", title, data, whole)


def _kinds(
    state: StateView, failed: Bools, rows: Iterable[int]
) -> Iterator[tuple[str, str, list[int]]]:
    """Words, colour and `rows` of those where the model holds, and of those where it fails."""
    fails = say("where “{model}” fails", model=state.key)
    for name, color, which in ((say("elsewhere"), fig.BLUE, False), (fails, fig.VERMILION, True)):
        if selected := [row for row in rows if bool(failed[row]) is which]:
            yield name, color, selected


def suspect_figure(events: Sequence[EventView], names: Names, loop: LoopView) -> Figure | None:
    """Partial residuals of the added effects, over what they go by."""
    found, before = loop.suspect, loop.before
    if found is None or before is None or (found.force and len(found.force.x)):
        return None
    effects = spoken().effects(found.effects)
    explained = say("explained by {effect}", effect=effects)
    values: Any = found.explained if found.column is None else found.values
    data: list[Trace] = []
    rows = np.flatnonzero(np.isfinite(found.missed) & np.isfinite(found.explained))
    texts = any(isinstance(values[k], str) for k in rows)
    order = np.argsort([values[k] for k in rows], kind="stable")
    x, y = [values[k] for k in rows[order]], found.explained[rows[order]]
    band = None if found.band is None else found.band[:, rows[order]]
    if band is not None and not texts:
        data.append(fig.area(x, band[0], band[1], BAND, name=say("90 % credible interval")))
    for name, color, selected in _kinds(before, before.failed, rows.tolist()):
        look = {"color": color, "size": 7, "opacity": 0.8}
        at, of = [values[k] for k in selected], [events[k] for k in selected]
        up = found.missed[selected]
        data.append(fig.event_marks(at, up, look, of, names, "%{y:+.2f}", name=name))
    if texts:
        look = {"color": fig.ORANGE, "size": 24, "symbol": "line-ew-open", "line": {"width": 3}}
        first = [x.index(value) for value in dict.fromkeys(x)]
        ticks = fig.marks([x[k] for k in first], y[first], look, name=explained)
        if band is not None:
            ticks["error_y"] = fig.error_bar(band[0, first], y[first], band[1, first], fig.ORANGE)
        data.append(ticks)
    else:
        data.append(fig.line(x, y, fig.ORANGE, 2.5, name=explained))
    across = say("log friction added by the effect")
    if found.column is not None:
        across = fig.label(axis_text(found.column))
    kind = {"type": "category", "categoryorder": "category ascending"} if texts else {}
    upwards = fig.axis(say("log friction beyond the law"), zeroline=True)
    places = fig.layout(fig.axis(across, **kind), upwards)
    return Figure("suspect", say("Missing effect: {effects}", effects=effects), data, places)


MOST_APART = 99.5
"""Percent of the measured forces that the picture has room for, at least."""


def force_shape_figure(events: Sequence[EventView], names: Names, loop: LoopView) -> Figure | None:
    """The fitted resistance over its state with its band, and the measured forces."""
    found, before = loop.suspect, loop.before
    if found is None or found.force is None or before is None:
        return None
    force, (effect,) = found.force, found.effects
    shape, name = force.shape, spoken().effect(effect)
    across, upwards = shape_text(shape)
    place = {e.event_id: k for k, e in enumerate(events)}
    of = np.array([place[event] for event in force.event], dtype=np.int64)
    data = [fig.area(shape.x, shape.q05, shape.q95, BAND, name=say("90 % credible interval"))]
    for words, color, rows in _kinds(before, before.failed[of], range(len(of))):
        look = {"color": color, "size": 5, "opacity": 0.6}
        bar = {"type": "data", "array": force.sd[rows], "thickness": 0.5, "width": 0}
        x, y, selected = force.x[rows], force.y[rows], [events[k] for k in of[rows]]
        own = {"name": words, "error_y": bar}
        data.append(fig.event_marks(x, y, look, selected, names, "%{y:+.2f}", **own))
    hover = "%{x:.4g}: %{y:+.3g}"
    fitted = say("{effect}, median", effect=name)
    data.append(fig.line(shape.x, shape.q50, fig.ORANGE, 3.0, hover, name=fitted))
    places = fig.layout(fig.axis(across), fig.axis(upwards, zeroline=True))
    if len(of):
        # To where speeds were measured: farther the curve rests on the stops alone.
        end = min(max(shape.x), ROOM * float(np.max(force.x)))
        shown = np.asarray(shape.x) <= end
        low, high = np.percentile(force.y, [100.0 - MOST_APART, MOST_APART])
        low = min(low, *np.asarray(shape.q05)[shown])
        high = max(high, *np.asarray(shape.q95)[shown])
        places["xaxis"]["range"] = [min(shape.x), end]
        places["yaxis"]["range"] = [low - 0.05 * (high - low), high + 0.05 * (high - low)]
    return Figure("force-shape", say("Missing effect: {effects}", effects=name), data, places)


ROW_PX = 24


def record_figure(events: Sequence[EventView], paths: Sequence[PathView]) -> Figure | None:
    """Dated events by year and path, larger where the volume was; None where none is dated."""
    names = {view.path.path_id: view.name for view in paths}
    dated = [e for e in events if e.year is not None]
    if not dated:
        return None
    rows = list(dict.fromkeys(_row(e, names) for e in dated))
    rows += [fig.label(view.name) for view in paths if fig.label(view.name) not in rows]
    data: list[Trace] = []
    known = [v for v in paths if None not in (v.path.observed_from, v.path.observed_to)]
    if known:
        x = [year for v in known for year in (v.path.observed_from, v.path.observed_to, None)]
        y = [name for v in known for name in (fig.label(v.name), fig.label(v.name), None)]
        data.append(fig.line(x, y, fig.ORANGE, 2.0, name=say("observed years"), opacity=0.6))
    for name, color, symbol, left in (
        (say("stopped on the profile"), fig.BLUE, "circle", False),
        (say("beyond the profile"), fig.VERMILION, "diamond-open", True),
    ):
        selected = [e for e in dated if e.left_profile is left]
        size = [_size(e.volume_m3) for e in selected]
        marker = {"color": color, "symbol": symbol, "opacity": 0.65, "size": size}
        if selected:
            x, y = [e.year for e in selected], [_row(e, names) for e in selected]
            data.append(fig.event_marks(x, y, marker, selected, names, name=name))
    upwards = fig.rows_axis(rows, tickfont={"size": 11})
    places = fig.layout(fig.axis(say("year")), upwards, height=130 + ROW_PX * len(rows))
    return Figure("record", say("The record through the years"), data, places)


def _row(event: EventView, names: Mapping[str, str]) -> str:
    if event.path_id is None:
        return say("no path")
    return fig.label(names.get(event.path_id, event.path_id))


def _size(volume_m3: float | None) -> float:
    """Diameter in pixels: 5 at 1,000 m3 and less, 3 more for each factor of 10."""
    return 6.0 if not volume_m3 else 5.0 + 3.0 * max(0.0, math.log10(volume_m3) - 3.0)
