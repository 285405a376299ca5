"""The posterior of the parameters: each by itself, and the first two together (4 and 6)."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice

import numpy as np

from avahazard.report.html.content import Floats
from avahazard.report.html.figure import Figure, label
from avahazard.report.html.style import BLUE, SKY, VERMILION, axis, layout
from avahazard.report.html.words import number, unit_words
from avahazard.results.calibration import ParameterSummary

BINS = 36
JOINT_DRAWS = 800
OFFSET = "path:"
SMALL_MARGIN = {"l": 62, "r": 20, "t": 10, "b": 62}


def posterior_figures(
    parameters: Mapping[str, ParameterSummary], draws: Mapping[str, Floats]
) -> list[Figure]:
    """A histogram for every parameter that moves, and the first two against each other."""
    moving = {name: v for name, v in draws.items() if np.ptp(v) > 0.0}
    figures = [
        _histogram(k, name, values, parameters[name])
        for k, (name, values) in enumerate(moving.items())
    ]
    if len(moving) > 1:
        figures.append(_joint(*islice(moving.items(), 2)))
    return figures


def offsets_figure(
    parameters: Mapping[str, ParameterSummary], names: Mapping[str, str]
) -> Figure | None:
    """How far each path's friction lies from that of all; None without a path effect."""
    rows = [(k.removeprefix(OFFSET), p) for k, p in parameters.items() if k.startswith(OFFSET)]
    if not rows:
        return None
    percent = [
        [100.0 * np.expm1(getattr(p, key)) for _, p in rows] for key in ("q05", "mean", "q95")
    ]
    low, middle, high = map(np.array, percent)
    return Figure(
        "offsets",
        "What sets the paths apart",
        f"Friction of {len(rows)} paths against that of all, with 90 % intervals.",
        "A path to the left of the line has less friction than the law says for its volumes, for "
        "a reason that the records do not hold.",
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
            axis("friction against that of all paths (%)", zeroline=True, zerolinecolor="#555"),
            axis("", type="category", autorange="reversed"),
            height=110 + 26 * len(rows),
        ),
    )


def _histogram(k: int, name: str, values: Floats, summary: ParameterSummary) -> Figure:
    counts, edges = np.histogram(values, bins=BINS, density=True)
    middle = 0.5 * (edges[1:] + edges[:-1])
    inside = (middle >= summary.q05) & (middle <= summary.q95)
    low, high, mean = (number(getattr(summary, key)) for key in ("q05", "q95", "mean"))
    unit = f" {unit_words(summary.unit)}" if summary.unit else ""
    return Figure(
        f"posterior-{k + 1}",
        name,
        f"Histogram of the posterior draws of {name}: mean {mean}, 90 % in {low} to {high}{unit}.",
        f"mean {mean}{unit}; 90 % in {low} to {high}{unit}",
        [
            {
                "type": "bar",
                "x": middle,
                "y": counts,
                "width": float(edges[1] - edges[0]),
                "marker": {"color": np.where(inside, BLUE, SKY).tolist(), "line": {"width": 0}},
                "hovertemplate": "%{x}<extra></extra>",
            }
        ],
        layout(
            axis(label(name) + (f"<br>({label(unit_words(summary.unit))})" if unit else ""),
                 exponentformat="power", nticks=3),
            axis("", showticklabels=False, ticks="", rangemode="tozero"),
            height=246,
            margin=SMALL_MARGIN,
            showlegend=False,
            bargap=0,
        ),
    )  # fmt: skip


def _joint(one: tuple[str, Floats], other: tuple[str, Floats]) -> Figure:
    every = max(1, len(one[1]) // JOINT_DRAWS)
    r = float(np.corrcoef(one[1], other[1])[0, 1])
    return Figure(
        "posterior-joint",
        f"{one[0]} and {other[0]} together",
        f"Posterior draws of {one[0]} against {other[0]}; their correlation is {r:.2f}.",
        f"correlation {r:.2f}".replace("-", "−"),
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
            axis(label(one[0]), exponentformat="power", nticks=3),
            axis(label(other[0]), exponentformat="power", nticks=3),
            height=246,
            margin={**SMALL_MARGIN, "l": 88},
        ),
    )
