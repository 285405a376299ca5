"""Where an effect acts, drawn on the profile: trees where it is forest, else a band."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.html.content import PlaceView
from avahazard.report.html.figure import Trace, label
from avahazard.report.html.style import GREEN, ORANGE
from avahazard.report.language import ENGLISH, Language

TREES_EVERY, ABOVE, POINTS = 0.016, 0.012, 30
"""Distance of the trees as a share of the path, their height over the ground as one of the drop,
and the points of a band."""


def place_traces(
    places: Sequence[PlaceView],
    smooth: SmoothProfile,
    end: float,
    language: Language = ENGLISH,
) -> list[Trace]:
    """A trace for each effect that acts on a part of this path, which is drawn up to `end` (m)."""
    traces: list[Trace] = []
    length = end - smooth.x_min
    for place in places:
        effect = language.effect(place.effect)
        name = label(language.say("{effect} acts here", effect=effect))
        if place.trees:
            parts = [np.arange(a, b, TREES_EVERY * length) for a, b in place.stretches]
            x = np.concatenate(parts)
            drop = float(np.ptp(smooth.height(np.linspace(smooth.x_min, smooth.x_max, 100))))
            traces.append(
                {
                    "type": "scatter",
                    "mode": "markers",
                    "name": name,
                    "x": x,
                    "y": smooth.height(x) + ABOVE * drop,
                    "marker": {"symbol": "triangle-up", "size": 9, "color": GREEN},
                    "hovertemplate": label(effect) + ": x %{x:.0f} m<extra></extra>",
                }
            )
            continue
        xs: list[float | None] = []
        ys: list[float | None] = []
        for a, b in place.stretches:
            x = np.linspace(a, b, POINTS)
            xs += [*x.tolist(), None]
            ys += [*smooth.height(x).tolist(), None]
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": name,
                "x": xs,
                "y": ys,
                "line": {"width": 7, "color": ORANGE},
                "opacity": 0.55,
                "hoverinfo": "name",
            }
        )
    return traces
