"""Figures of scores: where a model fails, its error beside others, measured force, candidates."""

from collections.abc import Mapping, Sequence
from itertools import cycle

from avahazard.criticism.scoring.error_budget import UNEXPLAINED
from avahazard.report.html import figure as fig
from avahazard.report.html.figure import Figure
from avahazard.report.language import say, spoken
from avahazard.report.words import (
    SIGNIFICANT,
    amount,
    axis_text,
    chance,
    level_text,
    part_text,
    unit_of,
)
from avahazard.results.base import RATIO
from avahazard.results.comparison import Comparison, LadderEntry, MeasuredForce
from avahazard.results.diagnosis import LEVEL, Diagnosis

PALE = "#B8B8B8"
SOURCE_COLORS = {
    "record": "#BBBBBB",
    "volume": "#56B4E9",
    "release": "#0072B2",
    "scatter": "#E69F00",
    "parameters": "#CC79A7",
    UNEXPLAINED: "#D55E00",
}
EXPLAINED = ("#009E73", "#66C2A5", "#1B7837", "#A6D96A")
"""Colours of what added effects explain."""


def budget_bars(
    names: Sequence[str], comparisons: Mapping[str, Comparison]
) -> dict[str, dict[str, float]]:
    """Metres by source of every compared model that has a budget, in the order of `names`."""
    return {
        name: {part.source: part.rms_m for part in comparisons[name].budget}
        for name in names
        if name in comparisons and comparisons[name].budget
    }


def parts_in_order(found: Mapping[str, Mapping[str, float]]) -> dict[str, str]:
    """The colour of every source: those of all models, each effect's, the unexplained last."""
    sources = dict.fromkeys(source for bar in found.values() for source in bar)
    effects = [source for source in sources if source not in SOURCE_COLORS]
    *known, last = SOURCE_COLORS
    colors = {**SOURCE_COLORS, **dict(zip(effects, cycle(EXPLAINED), strict=False))}
    return {source: colors[source] for source in (*known, *effects, last) if source in sources}


def ladder_figure(ladder: Sequence[LadderEntry], name: str) -> Figure | None:
    """A bar for every compared model, this one blue; None where none was compared."""
    rows = [row for row in ladder if row.held_out_crps_m is not None]
    if not rows:
        return None
    coordinate = rows[0].coordinate or "mixed"
    unit = unit_of(coordinate)
    errors = fig.axis(say("held-out CRPS, {unit}", unit=unit), rangemode="tozero")
    places = fig.layout(errors, fig.rows_axis(), height=120 + 34 * len(rows), bargap=0.35)
    floors = [row.noise_floor_crps_m for row in rows if row.noise_floor_crps_m is not None]
    if floors:
        floor, size = min(floors), amount(min(floors), coordinate, 0)
        look = {"color": fig.VERMILION, "width": 2, "dash": "dash"}
        ends = {"y0": 0, "y1": 1, "x0": floor, "x1": floor}
        places["shapes"] = [{"type": "line", "yref": "paper", **ends, "line": look}]
        places["annotations"] = [
            {"x": floor, "y": 1, "yref": "paper", "yanchor": "bottom", "xanchor": "left",
             "showarrow": False, "text": say("measurement-error floor: {error}", error=size),
             "font": {"color": fig.VERMILION, "size": 12}}
        ]  # fmt: skip
        places["margin"]["t"] = 28
    drawn = fig.bars(
        [row.held_out_crps_m for row in rows],
        [fig.label(row.model) for row in rows],
        [fig.BLUE if row.model == name else PALE for row in rows],
        f"%{{y}}: %{{x:.4g}} {unit}",
        text=[_changed(row, rows) for row in rows],
        textposition="auto",
        showlegend=False,
    )
    return Figure("ladder", say("Held-out error of each model"), [drawn], places)


def _changed(row: LadderEntry, rows: Sequence[LadderEntry]) -> str:
    """The error of a model, and how it differs from that of its parent."""
    errors = {known.model: known.held_out_crps_m for known in rows}
    now, before = errors[row.model], errors.get(row.parent or "")
    assert now is not None
    words = amount(now, row.coordinate, 0)
    if not before:
        return words
    return f"{words} ({spoken().number(f'{now / before - 1.0:+.0%}'.replace('%', ' %'))})"


LEAST_SHARE = 0.06
"""Of the longest bar: shorter segments have their metres on hover only."""


def budget_figure(
    ladder: Sequence[LadderEntry], comparisons: Mapping[str, Comparison]
) -> Figure | None:
    """A bar for every compared model with a budget; None where there is none."""
    found = budget_bars([row.model for row in ladder], comparisons)
    if not found:
        return None
    coordinate = next(iter(comparisons.values())).coordinate
    ratio, unit = coordinate == RATIO, unit_of(coordinate)
    longest = max(sum(v * v for v in bar.values()) for bar in found.values())
    data, names = [], [fig.label(name) for name in found]
    for source, color in parts_in_order(found).items():
        metres = [bar.get(source, 0.0) for bar in found.values()]
        size = f"%{{customdata:{'.4f' if ratio else '.1f'}}} {unit}"
        seen = [v * v >= LEAST_SHARE * longest for v in metres]
        text = [amount(v, coordinate, 0) if s else "" for v, s in zip(metres, seen, strict=True)]
        inside = {"textposition": "inside", "insidetextanchor": "middle", "textangle": 0}
        own = {"name": fig.label(part_text(source)), "text": text, "customdata": metres, **inside}
        hover = f"%{{y}}, %{{fullData.name}}: {size}"
        data.append(fig.bars([v * v for v in metres], names, color, hover, **own))
    squares = say("square of the error") + ("" if ratio else " (m²)")
    form = {"nticks": 4, "exponentformat": "none", "separatethousands": True}
    across, height = fig.axis(squares, rangemode="tozero", **form), 190 + 40 * len(found)
    places = fig.layout(across, fig.rows_axis(), height, barmode="stack", bargap=0.35)
    return Figure("budget", say("Where the error comes from"), data, places)


MOST_ROWS = 16


def effects_figure(diagnosis: Diagnosis) -> Figure | None:
    """The gain of every candidate, and the 95 % quantile of the gain by chance."""
    rows = diagnosis.candidates[:MOST_ROWS]
    if not rows:
        return None
    names = [_short(row.effect) for row in rows]
    # With room for the p-value beside the mark.
    most = max(max(row.chance_gain, row.screened_gain) for row in rows)
    floor = 1.0 / (diagnosis.n_worlds + 1)
    colors = [
        fig.VERMILION if row.effect in diagnosis.named
        else fig.ORANGE if row.p_value <= LEVEL
        else fig.BLUE
        for row in rows
    ]  # fmt: skip
    gains = fig.marks(
        [max(row.screened_gain, 0.0) for row in rows],
        names,
        {"color": colors, "size": 11, "symbol": "diamond"},
        "%{y}: %{x:.1f} nats, %{text}",
        mode="markers+text",
        textposition="middle right",
        cliponaxis=False,
        name=say("with the effect"),
        text=[fig.label(f"p {chance(row.p_value, floor)}") for row in rows],
    )
    alone = fig.bars([row.chance_gain for row in rows], names, "#CFCFCF", name=say("chance alone"))
    across = fig.axis(say("gain, nats"), range=[0.0, 1.4 * most])
    row_height = 36 if any("<br>" in name for name in names) else 28
    places = fig.layout(across, fig.rows_axis(), height=120 + row_height * len(rows))
    return Figure("effects", say("Candidate effects"), [alone, gains], places)


def _short(effect: str) -> str:
    """The name of an effect; of an interaction its columns alone, one below the other."""
    one, both, other = effect.partition(":")[2].partition("*")
    if both:
        return f"{fig.label(one)} ×<br>{fig.label(other)}"
    return fig.label(spoken().effect(effect))


def bias_figure(found: Comparison) -> Figure | None:
    """The bias of the worst levels, in colour what fails beyond chance; None without levels.

    For files alone: on a phone its names would leave no room, and the report has the table.
    """
    unit = unit_of(found.coordinate)
    rows = found.where_it_fails[:MOST_ROWS]
    if not rows:
        return None
    names = [fig.label(f"{axis_text(r.axis)}: {level_text(r.level)} ({r.n})") for r in rows]
    data = []
    for name, color, fails in (
        ("beyond chance", fig.VERMILION, True),
        ("not significant", PALE, False),
    ):
        selected = [k for k, row in enumerate(rows) if (row.p_value < SIGNIFICANT) is fails]
        if selected:
            x, y = [rows[k].bias_m for k in selected], [names[k] for k in selected]
            data.append(fig.bars(x, y, color, f"%{{y}}: %{{x:+.4g}} {unit}", name=name))
    across = fig.axis(f"predicted minus recorded ({unit})", zeroline=True)
    upwards = fig.rows_axis(names, categoryorder="array")
    places = fig.layout(across, upwards, height=130 + 24 * len(rows), barmode="overlay")
    return Figure("bias", "Where it fails", data, places)


def force_figure(force: Sequence[MeasuredForce]) -> Figure:
    """Resisting force per mass against speed, a colour for each event."""
    events = list(dict.fromkeys(row.event_id for row in force))
    data, hover = [], "%{fullData.name}: %{x:.1f} m/s, %{y:.1f} m/s²"
    for k, event in enumerate(events):
        selected = [row for row in force if row.event_id == event]
        color, symbol = fig.COLORS[k % len(fig.COLORS)], fig.SYMBOLS[k % len(fig.SYMBOLS)]
        u, force_by = [row.speed_m_s for row in selected], [row.force_m_s2 for row in selected]
        look = {"color": color, "symbol": symbol, "size": 6}
        own = {"name": fig.label(event), "showlegend": len(events) <= len(fig.COLORS)}
        sd = [row.sd_m_s2 for row in selected]
        bar = {"type": "data", "array": sd, "thickness": 0.7, "width": 0}
        data.append(fig.marks(u, force_by, look, hover, error_y=bar, **own))
    upwards = fig.axis(say("resisting force per mass (m/s²)"), zeroline=True)
    places = fig.layout(fig.axis(say("speed (m/s)")), upwards)
    return Figure("force", say("Force measured along the tracks"), data, places)
