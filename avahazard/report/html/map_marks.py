"""Scale and north of a map."""

from __future__ import annotations

import math
from typing import Any

from avahazard.report.html.figure import Trace
from avahazard.report.html.style import INK
from avahazard.report.html.words import metres
from avahazard.report.language import Language

Span = tuple[float, float]

M_PER_DEGREE = 111_320.0
"""Of latitude; of longitude at the equator."""
SHARE, INSET, TICK = 0.3, 0.04, 0.012
"""Most of the width that the bar takes, its distance from the edges, the height of its ends."""


def scale_bar(east: Span, north: Span, degrees: bool, language: Language) -> Trace:
    """A bar of a round length (m) in the lower left corner of what is shown."""
    middle = math.radians(0.5 * (north[0] + north[1]))
    unit = 1.0 / (M_PER_DEGREE * math.cos(middle)) if degrees else 1.0
    length = round_length(SHARE * (east[1] - east[0]) / unit)
    wide, high = east[1] - east[0], north[1] - north[0]
    x0, y0 = east[0] + INSET * wide, north[0] + INSET * high
    x1, up = x0 + length * unit, TICK * high
    return {
        "type": "scatter",
        "mode": "lines+text",
        "meta": "scale",
        "showlegend": False,
        "x": [x0, x0, x0, 0.5 * (x0 + x1), x1, x1, x1],
        "y": [y0 + up, y0 - up, y0, y0, y0, y0 + up, y0 - up],
        "text": ["", "", "", metres(length, language), "", "", ""],
        "textposition": "top center",
        "line": {"color": INK, "width": 2},
        "hoverinfo": "skip",
    }


def round_length(most: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is not over `most`."""
    power = 10.0 ** math.floor(math.log10(most))
    return next(k * power for k in (5.0, 2.0, 1.0) if k * power <= most)


def north_arrow() -> dict[str, Any]:
    """An arrow to the top of the map, which is north."""
    return {
        "xref": "paper",
        "yref": "paper",
        "x": 0.97,
        "y": 0.98,
        "ax": 0,
        "ay": 34,
        "text": "<b>N</b>",
        "showarrow": True,
        "arrowhead": 2,
        "arrowwidth": 2,
        "arrowcolor": INK,
        "yanchor": "top",
    }
