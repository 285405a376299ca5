"""The chance of every place along a path to be reached in a year."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avahazard.report.html.content import PathView
from avahazard.report.html.figure import Trace
from avahazard.report.html.style import BLUE
from avahazard.report.language import ENGLISH, Language

LEAST = 1e-5


def reach_of(view: PathView) -> Mapping[str, Any] | None:
    """The first row's chance to reach each place, None where the rows have none."""
    found = (row["reach"] for row in view.rows if row.get("reach"))
    return next(found, None)


def reach_traces(view: PathView, language: Language = ENGLISH) -> list[Trace]:
    """Median and 90 % of what the yearly chance may be, for a logarithmic axis."""
    reach = reach_of(view)
    assert reach is not None
    x = list(reach["x_m"])
    low, middle, high = (
        [max(p or 0.0, LEAST) for p in reach["p_per_year"][key]] for key in ("q05", "q50", "q95")
    )
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "x": [*x, *x[::-1]],
            "y": [*high, *low[::-1]],
            "fill": "toself",
            "fillcolor": "rgba(0,114,178,0.18)",
            "line": {"width": 0},
            "showlegend": False,
            "hoverinfo": "skip",
        },
        {
            "type": "scatter",
            "mode": "lines",
            "name": language.say("chance to be reached in a year"),
            "showlegend": False,
            "x": x,
            "y": middle,
            "line": {"color": BLUE, "width": 2},
            "hovertemplate": language.say(
                "x {x} m: {chance} a year", x="%{x:.0f}", chance="%{y:.2g}"
            )
            + "<extra></extra>",
        },
    ]
