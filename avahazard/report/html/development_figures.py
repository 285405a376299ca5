"""The held-out error from model to model, down to the floor."""

from __future__ import annotations

import math

from avahazard.criticism.screening.significance import LEVEL
from avahazard.report.html.content import ReportContent
from avahazard.report.html.figure import BLUE, ORANGE, VERMILION, Figure, Trace, axis, label, layout
from avahazard.report.html.words import amount, chance, coordinate_words, likelier
from avahazard.report.language import ENGLISH, Language
from avahazard.report.score_pictures import bars, part_words, parts_in_order
from avahazard.results.base import RATIO, unit_of
from avahazard.results.diagnosis import Diagnosis


def ladder_figure(content: ReportContent) -> Figure | None:
    """A bar for every compared model, this one blue; None where none was compared."""
    language, say = content.language, content.language.say
    rows = [row for row in content.ladder if row.held_out_crps_m is not None]
    if not rows:
        return None
    name = content.model.model
    coordinate = rows[0].coordinate or "mixed"
    of, unit = coordinate_words(coordinate, language), unit_of(coordinate)
    floors = [row.noise_floor_crps_m for row in rows if row.noise_floor_crps_m is not None]
    data: list[Trace] = [
        {
            "type": "bar",
            "orientation": "h",
            "x": [row.held_out_crps_m for row in rows],
            "y": [label(row.model) for row in rows],
            "text": [
                amount(row.held_out_crps_m, coordinate, 0, language)
                for row in rows
                if row.held_out_crps_m is not None
            ],
            "textposition": "auto",
            "marker": {"color": [BLUE if row.model == name else "#B8B8B8" for row in rows]},
            "hovertemplate": f"%{{y}}: %{{x:.4g}} {unit}<extra></extra>",
            "showlegend": False,
        }
    ]
    places = layout(
        axis(say("error ({unit} of {coordinate})", unit=unit, coordinate=of), rangemode="tozero"),
        axis("", type="category", autorange="reversed"),
        height=120 + 34 * len(rows),
        bargap=0.35,
    )
    if floors:
        places["shapes"] = [
            {
                "type": "line",
                "yref": "paper",
                "y0": 0,
                "y1": 1,
                "x0": min(floors),
                "x1": min(floors),
                "line": {"color": VERMILION, "width": 2, "dash": "dash"},
            }
        ]
        places["annotations"] = [
            {
                "x": min(floors),
                "y": 1,
                "yref": "paper",
                "yanchor": "bottom",
                "xanchor": "left",
                "showarrow": False,
                "text": say(
                    "errors of the data alone: {error}",
                    error=amount(min(floors), coordinate, 0, language),
                ),
                "font": {"color": VERMILION, "size": 12},
            }
        ]
        places["margin"]["t"] = 28
    lost = len(content.ladder) - len(rows)
    return Figure(
        "ladder",
        say("Error of each model on what it had not seen"),
        language.plural(
            "Bar of the held-out error of {n} model, with the floor that the errors of the records "
            "leave.",
            "Bars of the held-out error of {n} models, with the floor that the errors of the "
            "records leave.",
            len(rows),
        ),
        say(
            "The CRPS is a mean error in {unit} that counts the width of the forecast too; for a "
            "forecast without scatter it is the mean absolute error. The dashed line is what "
            "errors of the records alone (runout, volume, release) would leave: what varies from "
            "avalanche to avalanche comes on top for every model.",
            unit="H/L" if coordinate == RATIO else say("metres"),
        )
        + (
            " "
            + language.plural(
                "Left out: {n} model never compared.", "Left out: {n} models never compared.", lost
            )
            if lost
            else ""
        ),
        data,
        places,
    )


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


MOST_ROWS = 16
MOST_NATS = 600.0
"""More would be no number."""


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
        else ORANGE if row.p_value <= LEVEL
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
