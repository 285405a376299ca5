"""Where the error of each model comes from, as one stacked bar a model."""

from __future__ import annotations

from avahazard.report.html.content import ReportContent
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.style import axis, layout
from avahazard.report.html.words import amount
from avahazard.report.score_pictures import bars, part_words, parts_in_order
from avahazard.results.amounts import RATIO, unit_of

LEAST_SHARE = 0.06
"""Of the longest bar: shorter segments have their metres on hover only."""


def budget_figure(content: ReportContent) -> Figure | None:
    """A bar for every compared model with a budget; None where there is none."""
    language, say = content.language, content.language.say
    found = bars([row.model for row in content.ladder], content.loop.comparisons)
    if not found:
        return None
    coordinate = next(iter(content.loop.comparisons.values())).coordinate
    unit = unit_of(coordinate)
    longest = max(sum(v * v for v in bar.values()) for bar in found.values())
    models = [label(name) for name in found]
    data: list[Trace] = []
    for source, color in parts_in_order(found).items():
        metres = [bar.get(source, 0.0) for bar in found.values()]
        data.append(
            {
                "type": "bar",
                "orientation": "h",
                "name": label(part_words(source, language)),
                "x": [v * v for v in metres],
                "y": models,
                "text": [
                    amount(v, coordinate, 0, language) if v * v >= LEAST_SHARE * longest else ""
                    for v in metres
                ],
                "textposition": "inside",
                "insidetextanchor": "middle",
                "textangle": 0,
                "customdata": metres,
                "marker": {"color": color},
                "hovertemplate": "%{y}, %{fullData.name}: "
                f"%{{customdata:{'.4f' if coordinate == RATIO else '.1f'}}} {unit}<extra></extra>",
            }
        )
    return Figure(
        "budget",
        say("Where the error comes from"),
        language.plural(
            "Stacked bars of the error budget of {n} model.",
            "Stacked bars of the error budget of {n} models.",
            len(found),
        ),
        say(
            "Errors from sources that know nothing of each other add up by their squares, so the "
            "bars are squares, and the figures in them are {unit}, on the records of the "
            "calibration. Errors of the records, of their volumes and of their releases are no "
            "fault of the model; natural scatter is what varies from one avalanche to the next of "
            "the same volume. What an added effect explains was unexplained or taken for scatter "
            "before it.",
            unit="H/L" if coordinate == RATIO else say("metres"),
        ),
        data,
        layout(
            axis(
                say("square of the error") + ("" if coordinate == RATIO else " (m²)"),
                rangemode="tozero",
                nticks=5,
            ),
            axis("", type="category", autorange="reversed"),
            height=150 + 40 * len(found),
            barmode="stack",
            bargap=0.35,
        ),
    )
