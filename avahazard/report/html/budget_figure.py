"""Where the error of each model comes from, as one stacked bar a model."""

from __future__ import annotations

from avahazard.report.budget_parts import PART_WORDS, bars, parts_in_order
from avahazard.report.html.content import ReportContent
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.style import axis, layout

LEAST_SHARE = 0.06
"""Of the longest bar: shorter segments have their metres on hover only."""


def budget_figure(content: ReportContent) -> Figure | None:
    """A bar for every compared model with a budget; None where there is none."""
    found = bars([row.model for row in content.ladder], content.loop.comparisons)
    if not found:
        return None
    longest = max(sum(v * v for v in bar.values()) for bar in found.values())
    models = [label(name) for name in found]
    data: list[Trace] = []
    for source, color in parts_in_order(found).items():
        metres = [bar.get(source, 0.0) for bar in found.values()]
        data.append(
            {
                "type": "bar",
                "orientation": "h",
                "name": label(PART_WORDS.get(source, f"explained by {source}")),
                "x": [v * v for v in metres],
                "y": models,
                "text": [f"{v:.0f} m" if v * v >= LEAST_SHARE * longest else "" for v in metres],
                "textposition": "inside",
                "insidetextanchor": "middle",
                "textangle": 0,
                "customdata": metres,
                "marker": {"color": color},
                "hovertemplate": "%{y}, %{fullData.name}: %{customdata:.1f} m<extra></extra>",
            }
        )
    return Figure(
        "budget",
        "Where the error comes from",
        f"Stacked bars of the error budget of {len(found)} models.",
        "Errors from sources that know nothing of each other add up by their squares, so the bars "
        "are squares, and the figures in them are metres, on the records of the calibration. "
        "Errors of the records and of their volumes are no fault of the model; natural scatter is "
        "what varies from one avalanche to the next of the same volume. What an added effect "
        "explains was unexplained or taken for scatter before it.",
        data,
        layout(
            axis("square of the error (m²)", rangemode="tozero", nticks=5),
            axis("", type="category", autorange="reversed"),
            height=150 + 40 * len(found),
            barmode="stack",
            bargap=0.35,
        ),
    )
