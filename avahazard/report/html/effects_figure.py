"""Candidate effects, beside what chance alone would show."""

from __future__ import annotations

from avahazard.report.html.figure import Figure, label
from avahazard.report.html.style import BLUE, ORANGE, VERMILION, axis, layout
from avahazard.results.diagnosis import Diagnosis

MOST_ROWS = 16
LEAST_NATS = 0.1
SIGNIFICANT = 0.03


def effects_figure(diagnosis: Diagnosis) -> Figure | None:
    """The gain of every candidate, and the gain that chance alone reaches 19 times in 20."""
    rows = diagnosis.candidates[:MOST_ROWS]
    if not rows:
        return None
    named = set(diagnosis.missing)
    names = [label(row.effect) for row in rows]
    gain = [max(row.screened_gain or 0.0, LEAST_NATS) for row in rows]
    alone = [max(row.chance_gain or 0.0, LEAST_NATS) for row in rows]
    colors = [
        VERMILION if row.effect in named
        else ORANGE if row.p_value <= SIGNIFICANT
        else BLUE
        for row in rows
    ]  # fmt: skip
    return Figure(
        "effects",
        "Candidate effects",
        f"Gain in log likelihood of {len(rows)} candidate effects, beside the gain that chance "
        "alone would show.",
        "A mark right of its grey bar gains more than chance would, 19 times in 20, if the model "
        "were complete; among many candidates some do so by chance, and the p-value below allows "
        "for that. Red: named as missing. Gains under 0.1 are drawn at 0.1.",
        [
            {
                "type": "bar",
                "orientation": "h",
                "name": "chance alone",
                "x": [value - LEAST_NATS for value in alone],
                "base": LEAST_NATS,
                "y": names,
                "marker": {"color": "#CFCFCF"},
                "hoverinfo": "skip",
            },
            {
                "type": "scatter",
                "mode": "markers",
                "name": "gain of the effect",
                "x": gain,
                "y": names,
                "customdata": [[row.p_value] for row in rows],
                "marker": {"color": colors, "size": 11, "symbol": "diamond"},
                "hovertemplate": "%{y}: %{x:.1f} nats, p = %{customdata[0]:.3f}<extra></extra>",
            },
        ],
        layout(
            axis("gain in log likelihood (nats)", type="log", dtick=1),
            axis("", type="category", autorange="reversed"),
            height=120 + 28 * len(rows),
        ),
    )
