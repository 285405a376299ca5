"""Candidate effects, beside what chance alone would show."""

from __future__ import annotations

import math

from avahazard.report.html.figure import Figure, label
from avahazard.report.html.style import BLUE, ORANGE, VERMILION, axis, layout
from avahazard.report.html.words import chance, likelier
from avahazard.report.language import ENGLISH, Language
from avahazard.results.diagnosis import Diagnosis

MOST_ROWS = 16
MOST_NATS = 600.0
"""More would be no number."""
SIGNIFICANT = 0.03


def effects_figure(diagnosis: Diagnosis, language: Language = ENGLISH) -> Figure | None:
    """The gain of every candidate, and the gain that chance alone reaches 19 times in 20."""
    say, rows = language.say, diagnosis.candidates[:MOST_ROWS]
    if not rows:
        return None
    named = set(diagnosis.missing)
    names = [label(language.effect(row.effect)) for row in rows]
    floor = 1.0 / (diagnosis.n_worlds + 1)
    gain = [times(row.screened_gain) for row in rows]
    alone = [times(row.chance_gain) for row in rows]
    cut = len(diagnosis.candidates) - len(rows)
    colors = [
        VERMILION if row.effect in named
        else ORANGE if row.p_value <= SIGNIFICANT
        else BLUE
        for row in rows
    ]  # fmt: skip
    return Figure(
        "effects",
        say("Candidate effects"),
        say(
            "How much likelier the records are with each of {n} candidate effects, beside what "
            "chance alone would show.",
            n=len(rows),
        ),
        say(
            "How many times likelier the records are with the effect than without. A mark right "
            "of its grey bar is more than chance would do, 19 times in 20, if the model were "
            "complete; among many candidates some do so by chance, and the p-value below allows "
            "for that. Orange-red: named as missing; orange: more than chance would do, but not "
            "named."
        )
        + (
            " " + say("{n} more candidates, weaker than these, are in the table alone.", n=cut)
            if cut
            else ""
        ),
        [
            {
                "type": "bar",
                "orientation": "h",
                "name": say("chance alone"),
                "x": [value - 1.0 for value in alone],
                "base": 1.0,
                "y": names,
                "marker": {"color": "#CFCFCF"},
                "hoverinfo": "skip",
            },
            {
                "type": "scatter",
                "mode": "markers",
                "name": say("with the effect"),
                "x": gain,
                "y": names,
                "text": [
                    label(
                        say(
                            "{times} likelier, p {p}",
                            times=likelier(row.screened_gain, language),
                            p=chance(row.p_value, floor, language),
                        )
                    )
                    for row in rows
                ],
                "marker": {"color": colors, "size": 11, "symbol": "diamond"},
                "hovertemplate": "%{y}: %{text}<extra></extra>",
            },
        ],
        layout(
            axis(say("times likelier"), type="log", dtick=_ticks([*gain, *alone]),
                 exponentformat="power", tickangle=0),
            axis("", type="category", autorange="reversed"),
            height=120 + 28 * len(rows),
        ),
    )  # fmt: skip


def times(gain: float) -> float:
    """A gain in log likelihood (nats) as a ratio of likelihoods, no less than 1."""
    return math.exp(min(max(gain, 0.0), MOST_NATS))


def _ticks(ratios: list[float]) -> int:
    """Decades from tick to tick, so that few enough stand on a narrow axis."""
    return max(1, math.ceil(math.log10(max(ratios)) / 2.5))
