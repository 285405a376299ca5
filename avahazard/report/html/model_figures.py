"""Figures of the model: friction against volume, its density, the posterior."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.html.content import EventView, FrictionView
from avahazard.report.html.figure import (
    BLACK,
    BLUE,
    COLORS,
    SKY,
    VERMILION,
    Figure,
    Trace,
    axis,
    by_path,
    label,
    layout,
)
from avahazard.report.language import ENGLISH, Language
from avahazard.report.words import (
    event_words,
    number,
    unit_words,
)
from avahazard.results.calibration import ParameterSummary
from avahazard.results.friction import FrictionDensity


def friction_figure(
    view: FrictionView,
    events: Sequence[EventView],
    names: dict[str, str],
    language: Language = ENGLISH,
) -> Figure:
    """Median friction with the bands of the avalanches and of the law, and apparent frictions."""
    say = language.say
    x = view.volume.tolist()
    data: list[Trace] = []
    if view.scatter is not None:
        q05, q25, q75, q95 = view.scatter
        data += _band(view.volume, q05, q95, "rgba(86,180,233,0.22)", say("90 % of avalanches"))
        data += _band(view.volume, q25, q75, "rgba(86,180,233,0.40)", say("50 % of avalanches"))
    low, middle, high = view.law
    data += [
        {
            "type": "scatter",
            "mode": "lines",
            "name": say("median, and 90 % of what it may be"),
            "legendgroup": "law",
            "x": x,
            "y": middle.tolist(),
            "line": {"color": BLUE, "width": 2.5},
            "hovertemplate": say(
                "V = {volume} m³: median friction {friction}",
                volume="%{x:,.0f}",
                friction="%{y:.3f}",
            )
            + "<extra></extra>",
        },
        *(
            {
                "type": "scatter",
                "mode": "lines",
                "legendgroup": "law",
                "showlegend": False,
                "x": x,
                "y": edge.tolist(),
                "line": {"color": BLUE, "width": 1.2, "dash": "dash"},
                "hoverinfo": "skip",
            }
            for edge in (low, high)
        ),
    ]
    shown = [e for e in events if e.mu_reference is not None and e.volume_m3]
    for name, color, symbol, mine in by_path(shown, names, language):
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": label(name),
                "x": [e.volume_m3 for e in mine],
                "y": [e.mu_reference for e in mine],
                "text": [label(event_words(e, names, language)) for e in mine],
                "hovertemplate": "%{text}<br>"
                + say("apparent friction {friction}", friction="%{y:.3f}")
                + "<extra></extra>",
                "marker": {"color": color, "symbol": symbol, "size": 7, "opacity": 0.8},
            }
        )
    inside = "" if view.scatter is None else _inside(view, shown, language)
    lacking = len(events) - len(shown)
    return Figure(
        "friction",
        say("Friction against volume"),
        language.plural(
            "Apparent friction of {n} event against its volume, with the calibrated median and the "
            "bands that hold 50 and 90 % of avalanches.",
            "Apparent friction of {n} events against their volume, with the calibrated median and "
            "the bands that hold 50 and 90 % of avalanches.",
            len(shown),
        ),
        say(
            "Apparent friction is the one whose block, with the model’s effects on its motion, "
            "stops where the record says; what effects on friction and the path itself add to it "
            "is taken off, as it is from the curve. Large avalanches run farther where the curve "
            "falls. The model itself was fitted to the records, not to these points."
        )
        + inside
        + (
            " "
            + language.plural(
                "{n} event has no volume, or no friction stops the block at its record, and is "
                "not shown.",
                "{n} events have no volume, or no friction stops the block at their record, and "
                "are not shown.",
                lacking,
            )
            if lacking
            else ""
        ),
        data,
        layout(
            axis(say("volume (m³)"), type="log", exponentformat="power", dtick=1),
            axis(say("friction μ")),
            height=470,
        ),
    )


def _inside(view: FrictionView, events: Sequence[EventView], language: Language) -> str:
    """How many points lie in the wide band."""
    assert view.scatter is not None
    log_volume = np.log([e.volume_m3 or np.nan for e in events])
    low, high = (np.interp(log_volume, np.log(view.volume), view.scatter[k]) for k in (0, 3))
    mu = np.array([e.mu_reference for e in events], np.float64)
    n = int(np.sum((mu >= low) & (mu <= high)))
    return " " + language.say("{n} of {total} lie in the band of 90 %.", n=n, total=len(events))


def _band(x: Floats, low: Floats, high: Floats, color: str, name: str) -> list[Trace]:
    """A filled band as one closed line."""
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "fill": "toself",
            "fillcolor": color,
            "line": {"width": 0},
            "x": [*x.tolist(), *x[::-1].tolist()],
            "y": [*high.tolist(), *low[::-1].tolist()],
            "name": name,
            "hoverinfo": "skip",
        }
    ]


REACH = 4.0
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")


def density_figure(
    densities: Sequence[FrictionDensity], names: dict[str, str], language: Language = ENGLISH
) -> Figure | None:
    """The density of all events thick, that of each path thin; None where there is none."""
    if not densities:
        return None
    say = language.say
    many = len(densities) > len(COLORS)
    span = np.asarray(densities[0].mu)
    data: list[Trace] = []
    for k, density in enumerate(densities):
        whole = density.path_id == "all"
        mu, pdf = np.asarray(density.mu), np.asarray(density.pdf)
        beyond = np.asarray(density.extrapolated, dtype=bool)
        of = density.path_id
        name = say("all events") if whole else names.get(of, of)
        place = k if whole else list(names).index(density.path_id)
        color = BLACK if whole else COLORS[place % (len(COLORS) - 1)]
        common: Trace = {
            "type": "scatter",
            "mode": "lines",
            "legendgroup": density.path_id,
            "visible": True if whole or not many else "legendonly",
            "hovertemplate": "μ = %{x:.3f}<extra>%{fullData.name}</extra>",
            "name": label(f"{name} ({density.n})"),
        }
        line = {"color": color, "width": 3 if whole else 1.6}
        data.append(
            {
                **common,
                "x": mu[~beyond],
                "y": pdf[~beyond],
                "line": {**line, "dash": "solid" if whole else DASHES[place % len(DASHES)]},
            }
        )
        data.append(
            {
                **common,
                "x": mu[beyond],
                "y": np.where(_gap(beyond)[beyond], np.nan, pdf[beyond]),
                "line": {**line, "width": 0.8, "dash": "dot"},
                "showlegend": False,
                "hoverinfo": "skip",
            }
        )
        if density.sd > 0.0:
            data.append(_normal(density, common, whole, color, say("normal of all events")))
    return Figure(
        "density",
        say("How apparent friction is spread"),
        language.plural(
            "Probability density of apparent friction of all events and of {n} path.",
            "Probability density of apparent friction of all events and of {n} paths.",
            len(densities) - 1,
        ),
        say(
            "The area under each curve is 1; the number of events is in brackets. Dotted parts "
            "lie beyond the records: they are an assumption of the method (Holy 1997). Thin lines "
            "are normal distributions of the same mean and standard deviation."
        )
        + (" " + say("Tap a name in the legend to show its path.") if many else ""),
        data,
        layout(
            axis(say("apparent friction μ"), range=[max(0.0, span[0]), span[-1]]),
            axis(say("probability density"), rangemode="tozero"),
        ),
    )


def _normal(density: FrictionDensity, common: Trace, whole: bool, color: str, name: str) -> Trace:
    """The normal of the same mean and sd, within four of these and friction over 0."""
    mean, sd = density.mean, density.sd
    mu = np.linspace(max(0.0, mean - REACH * sd), mean + REACH * sd, NORMAL_POINTS)
    own = {"name": label(name)} if whole else {"showlegend": False}
    return {
        **common,
        "x": mu,
        "y": np.exp(-0.5 * ((mu - mean) / sd) ** 2) / (sd * np.sqrt(2.0 * np.pi)),
        "line": {"color": VERMILION if whole else color, "width": 1.6 if whole else 0.7},
        "opacity": 1.0 if whole else 0.6,
        "hoverinfo": "skip",
        **own,
    }


def _gap(beyond: np.ndarray) -> np.ndarray:
    """The first place after a break, so that the tails on both sides are not joined."""
    return np.concatenate([[False], beyond[1:] & ~beyond[:-1]])


BINS, NORMAL_POINTS = 36, 61
JOINT_DRAWS = 800
OFFSET = "path:"
SMALL_MARGIN = {"l": 62, "r": 20, "t": 10, "b": 62}


def posterior_figures(
    parameters: Mapping[str, ParameterSummary],
    draws: Mapping[str, Floats],
    language: Language = ENGLISH,
) -> list[Figure]:
    """A histogram for every parameter that moves, and the first two against each other.

    Over each histogram lies the normal of the draws' mean and standard deviation.
    """
    moving = {name: v for name, v in draws.items() if np.ptp(v) > 0.0}
    figures = [
        _histogram(k, name, values, parameters[name], language)
        for k, (name, values) in enumerate(moving.items())
    ]
    if len(moving) > 1:
        one, other = islice(moving.items(), 2)
        figures.append(_joint(one, other, language))
    return figures


def offsets_figure(
    parameters: Mapping[str, ParameterSummary],
    names: Mapping[str, str],
    language: Language = ENGLISH,
) -> Figure | None:
    """How far each path's friction lies from that of all; None without a path effect."""
    say = language.say
    rows = [(k.removeprefix(OFFSET), p) for k, p in parameters.items() if k.startswith(OFFSET)]
    if not rows:
        return None
    percent = [
        [100.0 * np.expm1(getattr(p, key)) for _, p in rows] for key in ("q05", "mean", "q95")
    ]
    low, middle, high = map(np.array, percent)
    return Figure(
        "offsets",
        say("What sets the paths apart"),
        say("Friction of {n} paths against that of all, with 90 % intervals.", n=len(rows)),
        say(
            "A path to the left of the line has less friction than the law says for its volumes, "
            "for a reason that the records do not hold."
        ),
        [
            {
                "type": "scatter",
                "mode": "markers",
                "x": middle,
                "y": [label(names.get(path_id, path_id)) for path_id, _ in rows],
                "error_x": {
                    "type": "data",
                    "symmetric": False,
                    "array": high - middle,
                    "arrayminus": middle - low,
                    "color": BLUE,
                },
                "marker": {"color": BLUE, "size": 8},
                "hovertemplate": "%{y}: %{x:+.1f} %<extra></extra>",
            }
        ],
        layout(
            axis(
                say("friction against that of all paths (%)"), zeroline=True, zerolinecolor="#555"
            ),
            axis("", type="category", autorange="reversed"),
            height=110 + 26 * len(rows),
        ),
    )


def _histogram(
    k: int, name: str, values: Floats, summary: ParameterSummary, language: Language
) -> Figure:
    counts, edges = np.histogram(values, bins=BINS, density=True)
    middle = 0.5 * (edges[1:] + edges[:-1])
    inside = (middle >= summary.q05) & (middle <= summary.q95)
    low, high, mean = (number(getattr(summary, key), language) for key in ("q05", "q95", "mean"))
    unit = f" {unit_words(summary.unit, language)}" if summary.unit else ""
    normal = np.linspace(edges[0], edges[-1], NORMAL_POINTS)
    z = (normal - np.mean(values)) / np.std(values)
    numbers = language.say(
        "mean {mean}{unit}; 90 % in {low} to {high}{unit}", mean=mean, low=low, high=high, unit=unit
    )
    return Figure(
        f"posterior-{k + 1}",
        name,
        language.say(
            "Histogram of the posterior draws of {name}: {numbers}.", name=name, numbers=numbers
        ),
        numbers,
        [
            {
                "type": "bar",
                "x": middle,
                "y": counts,
                "width": float(edges[1] - edges[0]),
                "marker": {"color": np.where(inside, BLUE, SKY).tolist(), "line": {"width": 0}},
                "hovertemplate": "%{x}<extra></extra>",
            },
            {
                "type": "scatter",
                "mode": "lines",
                "x": normal,
                "y": np.exp(-0.5 * z * z) / (np.std(values) * np.sqrt(2.0 * np.pi)),
                "line": {"color": VERMILION, "width": 1.8},
                "hoverinfo": "skip",
            },
        ],
        layout(
            _small_axis(label(name) + (f"<br>({label(unit.strip())})" if unit else "")),
            axis("", showticklabels=False, ticks="", rangemode="tozero"),
            height=246,
            margin=SMALL_MARGIN,
            showlegend=False,
            bargap=0,
        ),
    )  # fmt: skip


def _small_axis(title: str) -> dict[str, Any]:
    """An axis with few ticks and small words: units are long in French."""
    small = axis(title, exponentformat="power", nticks=3)
    return {**small, "title": {**small["title"], "font": {"size": 12}}}


def _joint(one: tuple[str, Floats], other: tuple[str, Floats], language: Language) -> Figure:
    every = max(1, len(one[1]) // JOINT_DRAWS)
    r = language.number(f"{np.corrcoef(one[1], other[1])[0, 1]:.2f}")
    return Figure(
        "posterior-joint",
        language.say("{one} and {other} together", one=one[0], other=other[0]),
        language.say(
            "Posterior draws of {one} against {other}; their correlation is {r}.",
            one=one[0],
            other=other[0],
            r=r,
        ),
        language.say("correlation {r}", r=r),
        [
            {
                "type": "scatter",
                "mode": "markers",
                "x": one[1][::every],
                "y": other[1][::every],
                "marker": {"color": VERMILION, "size": 3, "opacity": 0.5},
                "hoverinfo": "skip",
            }
        ],
        layout(
            _small_axis(label(one[0])),
            _small_axis(label(other[0])),
            height=246,
            margin={**SMALL_MARGIN, "l": 88},
        ),
    )
