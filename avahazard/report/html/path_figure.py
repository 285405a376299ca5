"""One path along its length: the profile with its runouts, the speeds, the chance to be reached."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.html import figure as fig
from avahazard.report.html.content import EventView, LoopView, PathView, StateView
from avahazard.report.html.figure import Figure, States, Trace
from avahazard.report.language import say
from avahazard.report.words import case, integer, volume_text, years
from avahazard.results.hazard import HazardRow, Place, PlaceQuantiles, ReachChance, Spread, Zone

PLACES = 160
HUMP = 0.05
"""Height of the distribution where it is densest, as a share of the drop."""


def runout_traces(smooth: SmoothProfile, row: HazardRow, level: int, drop: float) -> list[Trace]:
    """The design runout of a row, and thinner that of avalanches of its volume.

    They lie `level` steps above the ground, on a path with this `drop` (m). The legend names the
    latter in the first row only: it stands for all.
    """
    of, traces = case(row), list[Trace]()
    color, above = fig.ROW_COLORS[level - 1], level * STEP * drop
    own = {"color": color, "legendgroup": f"row {of}", "opacity": 0.8}

    def bar(found: Spread | PlaceQuantiles, name: str, width: float, **more: Any) -> list[Trace]:
        def at(x: Floats) -> tuple[Floats, Floats]:
            return x, smooth.height(x) + above

        look = _tick(9.0 + width, 1.0 + width / 3.0, color)
        return fig.runout_bar(at, found, smooth.x_max, name, {**own, "width": width, **more}, look)

    if row.design:
        traces += bar(row.design.runout_x_m, say("design runout, {case}", case=of), 6.0)
    if row.runout_x_m.q05 is not None:
        name = say("avalanches of {volume}", volume=volume_text(row))
        traces += bar(row.runout_x_m, name, 1.2, showlegend=level == 1 or not row.design)
        traces += _spread(smooth, row, color, above, drop, f"row {of}")
    return traces


def _spread(
    smooth: SmoothProfile, row: HazardRow, color: str, above: float, drop: float, group: str
) -> list[Trace]:
    """The distribution of the runout upon its bar: equal areas hold equal shares."""
    steps = [float(x) for x in row.runout_x_steps_m if x is not None]
    x, width = np.array(steps), np.diff(steps)
    if len(x) < 3 or np.any(width <= 0.0):
        return []
    middle = 0.5 * (x[1:] + x[:-1])
    density = np.interp(x, middle, 1.0 / width)
    upper = density / density.max() * HUMP * drop
    base = smooth.height(x) + above
    own = {"legendgroup": group, "showlegend": False, "opacity": 0.3}
    return [fig.area(x, base, base + upper, color, **own)]


STEP = 0.055
"""Distance of the bars from the ground and from each other, as a share of the drop."""
FOOT, TOP = 0.13, 0.08
"""Room under and over the ground, as shares of the drop."""
MOST_ROWS = len(fig.ROW_COLORS)


def profile_traces(
    view: PathView, smooth: SmoothProfile, release: float
) -> tuple[list[Trace], list[float]]:
    """Ground, release, recorded stops, and for every row its runout above the ground.

    Also the lowest and the highest elevation to show.
    """
    x, rows = np.linspace(smooth.x_min, smooth.x_max, PLACES), view.rows[:MOST_ROWS]
    y = smooth.height(x)
    drop = float(np.ptp(y))
    foot = float(y.min()) - FOOT * drop
    top = float(y.max()) + (max(TOP, STEP * len(rows) + HUMP) if rows else TOP) * drop
    hover = say("x {x} m, {y} m", x="%{x:.0f}", y="%{y:.0f}")
    traces = [
        fig.area(x, np.full(len(x), foot), y, fig.GROUND, name=say("ground"), showlegend=False),
        fig.line(x, y, fig.INK, 1.4, hover, name=say("profile, smoothed"), showlegend=False),
    ]
    traces += _zones(view.drawn_zones, foot, drop)
    for level, row in enumerate(rows, start=1):
        traces += runout_traces(smooth, row, level, drop)
    traces += _alpha_beta(view, smooth, 0.5 * STEP * drop)
    look: dict[str, Any] = {"symbol": "triangle-down", "size": 11, "color": fig.BLACK}
    hover = say("release: x {x} m, {y} m", x="%{x:.0f}", y="%{y:.0f}")
    own = {"name": say("release"), "cliponaxis": False}
    traces.append(fig.marks([release], [float(smooth.height(release))], look, hover, **own))
    stops = [e for e in view.events if e.stop_x_m is not None]
    if stops:
        places = np.array([e.stop_x_m for e in stops], dtype=np.float64)
        names = {view.path.path_id: view.name}
        hover = say("stopped at x {x} m, {y} m", x="%{x:.0f}", y="%{y:.0f}")
        own = {"name": say("recorded stops"), "cliponaxis": False}
        y = smooth.height(np.clip(places, smooth.x_min, smooth.x_max))
        traces.append(fig.event_marks(places, y, _tick(13, 1.3), stops, names, hover, **own))
    return traces, [foot, top]


def _tick(size: float, width: float, color: str = fig.INK) -> dict[str, Any]:
    """A mark that is a line upwards."""
    return {"symbol": "line-ns-open", "size": size, "color": color,
            "line": {"width": width, "color": color}}  # fmt: skip


def _alpha_beta(view: PathView, smooth: SmoothProfile, below: float) -> list[Trace]:
    """The α-β runouts, under the ground."""
    traces: list[Trace] = []
    for number, row in enumerate(view.alpha_beta):
        place = row.runout_x_m
        if place is None:
            continue
        low = place if row.runout_x_low_m is None else row.runout_x_low_m
        high = smooth.x_max if row.runout_x_high_m is None else row.runout_x_high_m
        color = ("#6B5400", "#7A3E9D")[number % 2]
        by, ends = say(row.coefficients.capitalize()), {"low": integer(low), "high": integer(high)}
        hover = say(
            "α-β, {coefficients}: x {x} m ({low} to {high})", coefficients=by, x="%{x:.0f}", **ends
        )
        y = float(smooth.height(place)) - (1.0 + number) * below
        look = {"symbol": "star", "size": 12, "color": color}
        name = say("α-β, {coefficients}", coefficients=by)
        bar = fig.error_bar([low], [place], [high], color)
        traces.append(fig.marks([place], [y], look, hover, name=name, error_x=bar))
    return traces


def _zones(zones: Sequence[Zone], foot: float, drop: float) -> list[Trace]:
    """A strip in the colour of each zone at the foot of the panel."""
    traces, y = [], [foot + 0.03 * drop] * 2
    for zone in zones:
        of = say(zone.zone)
        name, hover = fig.label(say("zone: {zone}", zone=of)), fig.label(of) + ": x %{x:.0f} m"
        x = [zone.from_x_m, zone.to_x_m]
        traces.append(fig.line(x, y, zone.color, 10.0, hover, name=name))
    return traces


LEAST = 1e-5


def reach_traces(reach: ReachChance) -> list[Trace]:
    """Median and 90 % of what the yearly chance may be, for a logarithmic axis."""
    x = list(reach.x_m)
    low, middle, high = (
        [max(p or 0.0, LEAST) for p in getattr(reach.p_per_year, key)]
        for key in ("q05", "q50", "q95")
    )
    name = say("chance to be reached in a year")
    hover = say("x {x} m: {chance} a year", x="%{x:.0f}", chance="%{y:.2g}")
    return [
        fig.area(x, low, high, "rgba(0,114,178,0.18)", showlegend=False),
        fig.line(x, middle, fig.BLUE, 2.0, hover, name=name, showlegend=False),
    ]


def speed_traces(view: PathView) -> list[Trace]:
    """Speed in m/s over x; empty where nothing is known of it."""
    if view.zones and view.zones.places:
        return _quantiles(view.zones.places, view.rows)
    cases = [case(row) for row in view.rows]
    traces = []
    for row, x, speed in view.speeds:
        of = case(row)
        hover = say("{case}: {speed} m/s at x {x} m", case=of, speed="%{y:.1f}", x="%{x:.0f}")
        color = fig.ROW_COLORS[cases.index(of) % len(fig.ROW_COLORS)]
        traces.append(fig.line(x, speed, color, 2.0, hover, **_speed_of(of)))
    return traces


def _speed_of(of: str, *, legend: bool = False) -> dict[str, Any]:
    name = say("speed, {case}", case=of)
    return {"name": name, "legendgroup": f"row {of}", "showlegend": legend}


def _quantiles(places: Sequence[Place], rows: Sequence[HazardRow]) -> list[Trace]:
    """The 5, 50 and 95 % of the speed of each return period, with the pressure on hover."""
    periods = [entry.return_period_years for entry in places[0].by_return_period]
    known = [row.return_period_years for row in rows]
    traces, x = [], [place.x_m for place in places]
    for k, period in enumerate(periods):
        number = known.index(period) if period in known else k
        color = fig.ROW_COLORS[number % len(fig.ROW_COLORS)]
        of = years(period)
        entries = [place.by_return_period[k] for place in places]
        for key, width, dash in (("q50", 2.0, "solid"), ("q95", 1.0, "dash"), ("q05", 1.0, "dot")):
            hover = say(
                "{case}, {share} %: {speed} m/s, {pressure} kPa at x {x} m",
                case=of,
                share=str(int(key[1:])),
                speed="%{y:.1f}",
                pressure="%{customdata:.0f}",
                x="%{x:.0f}",
            )
            speeds = _moving([getattr(entry.speed_m_s, key) for entry in entries])
            # Where no row has its colour in the legend.
            own = _speed_of(of, legend=key == "q50" and period not in known)
            own["customdata"] = [getattr(e.pressure_kpa, key) for e in entries]
            traces.append(fig.line(x, speeds, color, width, hover, dash=dash, **own))
    return traces


def _moving(speeds: list[float]) -> list[float | None]:
    """Speeds up to the first place beyond all that are reached: some start below the first."""
    last = max((i for i, u in enumerate(speeds) if u), default=0)
    return [u if i <= last + 1 else None for i, u in enumerate(speeds)]


BEFORE, ROW_PX, LEAST_PX, MOST_PX = "#BDBDBD", 7, 70, 260


def stops_of(view: PathView, loop: LoopView, events: Sequence[EventView]) -> list[int]:
    """Which of all events are shown: those of the path with a place, by volume, smallest first."""
    if not loop.models:
        return []
    predicted = np.all(np.isfinite(loop.models[0].x), axis=1)
    own = [k for k, e in enumerate(events) if e.path_id == view.path.path_id and predicted[k]]
    known = [k for k in own if events[k].stop_x_m is not None]
    return sorted(known, key=lambda k: events[k].volume_m3 or 0.0)


def stops_traces(
    view: PathView, loop: LoopView, events: Sequence[EventView], shown: Sequence[int]
) -> tuple[list[Trace], dict[str, Mapping[int, Trace]]]:
    """Bands of the parent and of the model, the medians, the records; and what states change.

    A band holds 90 % of where the block of that record is expected to stop.
    """
    states = {state.key: state for state in loop.models}
    name, before = loop.lineage[-1], loop.before
    rows = np.arange(1.0, len(shown) + 1.0)
    names = {view.path.path_id: view.name}
    traces: list[Trace] = []
    if before is not None and before.key != name:
        by_parent = say("90 % by “{model}”", model=before.key)
        traces.append(_bands(before, shown, rows, by_parent, BEFORE, 5.0))
    band = len(traces)
    traces.append(_bands(states[name], shown, rows, say("90 % of the model shown"), fig.BLUE, 2.4))
    median = say("median of the model shown: x {x} m", x="%{x:.0f}")
    dot = {"color": fig.BLUE, "size": 4}
    traces.append(fig.marks(states[name].x[shown, 1], rows, dot, median, showlegend=False))
    hover = say("stopped at x {x} m", x="%{x:.0f}")
    selected = [events[k] for k in shown]
    stops = [event.stop_x_m for event in selected]
    look, own = _tick(8, 1.6), {"showlegend": False}
    traces.append(fig.event_marks(stops, rows, look, selected, names, hover, **own))
    changes: dict[str, Mapping[int, Trace]] = {
        key: {band: {"x": _ends(state, shown)}, band + 1: {"x": state.x[shown, 1]}}
        for key, state in states.items()
    }
    return traces, changes


def _bands(
    state: StateView, shown: Sequence[int], rows: Floats, name: str, color: str, width: float
) -> Trace:
    y = [v for row in rows.tolist() for v in (row, row, None)]
    return fig.line(_ends(state, shown), y, color, width, name=fig.label(name))


def _ends(state: StateView, shown: Sequence[int]) -> list[float | None]:
    """Both ends of every band, and a gap after it."""
    return [v for k in shown for v in (float(state.x[k, 0]), float(state.x[k, 2]), None)]


ROOM = 1.15
ONCE_IN: dict[str, Any] = {
    "type": "log",
    "range": [-4.0, 0.15],
    "tickvals": [1.0, 0.1, 0.01, 0.001, 0.0001],
    "ticktext": ["1", "1/10", "1/100", "1/1000", "1/10 000"],
}
PROFILE_PX, PANEL_PX, GAP_PX = 340, 140, 32


def path_figure(
    k: int,
    view: PathView,
    loop: LoopView | None = None,
    all_events: Sequence[EventView] = (),
    *,
    drag: bool = True,
) -> Figure | None:
    """Panels above one another over the same x; None for a path without a profile.

    The axis of speeds says so where no `drag` limits them.
    """
    if view.smooth is None or view.release_x is None:
        return None
    shown = [] if loop is None else stops_of(view, loop, all_events)
    models = () if loop is None else loop.models
    bands = [float(np.max(state.x[shown, 2])) for state in models if shown]
    end = shown_end(view, view.smooth, bands)
    ground, shown_y = profile_traces(view, view.smooth, view.release_x)
    heights = fig.axis(say("elevation (m)"), range=shown_y)
    panels: list[tuple[list[Trace], dict[str, Any], int]] = [(ground, heights, PROFILE_PX)]
    states: States = {}
    if loop is not None and shown:
        traces, changes = stops_traces(view, loop, all_events, shown)
        states = {
            key: {len(ground) + number: trace for number, trace in change.items()}
            for key, change in changes.items()
        }
        rows = fig.axis(say("records"), range=[0.0, len(shown) + 1.0], showticklabels=False)
        px = int(np.clip(ROW_PX * len(shown), LEAST_PX, MOST_PX))
        panels.append((traces, {**rows, "ticks": "", "showgrid": False}, px))
    speeds = speed_traces(view)
    if speeds:
        of_speed = say("speed (m/s)") if drag else say("speed without drag (m/s)")
        panels.append((speeds, fig.axis(of_speed, rangemode="tozero"), PANEL_PX))
    reach = next((row.reach for row in view.rows if row.reach), None)
    if reach is not None:
        upwards = fig.axis(say("annual probability"), **ONCE_IN)
        panels.append((reach_traces(reach), upwards, PANEL_PX))
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
    shown_x = [view.smooth.x_min, end]
    across = fig.axis(say("distance along the path x (m)"), anchor=last, range=shown_x)
    axes |= {"height": total + 130, "margin": fig.WIDE_MARGIN}
    whole = fig.layout(across, axes.pop("yaxis"), **axes)
    return Figure(f"path-{k}", say("Along the path"), data, whole, states=states)


def shown_end(view: PathView, smooth: SmoothProfile, more: Sequence[float] = ()) -> float:
    """x (m) to which the path is drawn: a little past all that is shown there, and `more`."""
    found: list[PlaceQuantiles | Spread] = [row.runout_x_m for row in view.rows]
    found += [row.design.runout_x_m for row in view.rows if row.design]
    ends = [end for place in found for end in (place.q50, place.q95)]
    ends += [row.runout_x_m for row in view.alpha_beta if row.runout_x_m is not None]
    ends += more
    stops = [e.stop_x_m for e in view.events if e.stop_x_m is not None]
    known = [end for end in ends if end is not None]
    if (not ends and not stops) or len(known) < len(ends):
        return smooth.x_max
    length = ROOM * (max([*known, *stops]) - smooth.x_min)
    return float(min(smooth.x_min + length, smooth.x_max))
