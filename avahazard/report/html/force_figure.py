"""The force measured along tracks with speeds: Coulomb friction or drag, seen by eye."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.report.html.figure import Figure, label
from avahazard.report.html.style import COLORS, SYMBOLS, axis, layout
from avahazard.report.language import ENGLISH, Language
from avahazard.results.comparison import MeasuredForce


def force_figure(force: Sequence[MeasuredForce], language: Language = ENGLISH) -> Figure:
    """Resisting force per mass against speed, a colour for each event."""
    say = language.say
    events = list(dict.fromkeys(row.event_id for row in force))
    data = []
    for k, event in enumerate(events):
        mine = [row for row in force if row.event_id == event]
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": label(event),
                "showlegend": len(events) <= len(COLORS),
                "x": [row.speed_m_s for row in mine],
                "y": [row.force_m_s2 for row in mine],
                "error_y": {
                    "type": "data",
                    "array": [row.sd_m_s2 for row in mine],
                    "thickness": 0.7,
                    "width": 0,
                },
                "marker": {
                    "color": COLORS[k % len(COLORS)],
                    "symbol": SYMBOLS[k % len(SYMBOLS)],
                    "size": 6,
                },
                "hovertemplate": "%{fullData.name}: %{x:.1f} m/s, %{y:.1f} m/s²<extra></extra>",
            }
        )
    return Figure(
        "force",
        say("Force measured along the tracks"),
        language.plural(
            "Resisting force per mass against speed, measured on {n} event.",
            "Resisting force per mass against speed, measured on {n} events.",
            len(events),
        ),
        say("Flat: Coulomb friction, as in the base model. Rising with the square of speed: drag."),
        data,
        layout(
            axis(say("speed (m/s)")), axis(say("resisting force per mass (m/s²)"), zeroline=True)
        ),
    )
