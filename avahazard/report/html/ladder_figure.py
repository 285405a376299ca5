"""The held-out error from model to model, down to the floor."""

from __future__ import annotations

from avahazard.report.html.content import ReportContent
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.style import BLUE, VERMILION, axis, layout
from avahazard.report.html.words import amount, coordinate_words
from avahazard.results.amounts import RATIO, unit_of


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
