"""The posterior of the parameters: each by itself, and the first two together (4 and 6)."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.html.figure import Figure, label
from avahazard.report.html.style import BLUE, SKY, VERMILION, axis, layout
from avahazard.report.html.words import number, unit_words
from avahazard.report.language import ENGLISH, Language
from avahazard.results.calibration import ParameterSummary

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
