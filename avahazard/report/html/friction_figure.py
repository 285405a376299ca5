"""Friction against volume: the calibrated law, its bands and the events (the paper's 5 and 7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.html.content import EventView, FrictionView
from avahazard.report.html.figure import Figure, Trace, label
from avahazard.report.html.style import BLUE, axis, by_path, layout
from avahazard.report.html.words import event_words
from avahazard.report.language import ENGLISH, Language


def friction_figure(
    view: FrictionView,
    events: Sequence[EventView],
    names: dict[str, str],
    language: Language = ENGLISH,
) -> Figure:
    """Median friction with the bands of the avalanches and of the law, and apparent frictions."""
    say = language.say
    x = view.volume.tolist()
    data: list[Trace] = []
    if view.scatter is not None:
        q05, q25, q75, q95 = view.scatter
        data += _band(view.volume, q05, q95, "rgba(86,180,233,0.22)", say("90 % of avalanches"))
        data += _band(view.volume, q25, q75, "rgba(86,180,233,0.40)", say("50 % of avalanches"))
    low, middle, high = view.law
    data += [
        {
            "type": "scatter",
            "mode": "lines",
            "name": say("median, and 90 % of what it may be"),
            "legendgroup": "law",
            "x": x,
            "y": middle.tolist(),
            "line": {"color": BLUE, "width": 2.5},
            "hovertemplate": say(
                "V = {volume} m³: median friction {friction}",
                volume="%{x:,.0f}",
                friction="%{y:.3f}",
            )
            + "<extra></extra>",
        },
        *(
            {
                "type": "scatter",
                "mode": "lines",
                "legendgroup": "law",
                "showlegend": False,
                "x": x,
                "y": edge.tolist(),
                "line": {"color": BLUE, "width": 1.2, "dash": "dash"},
                "hoverinfo": "skip",
            }
            for edge in (low, high)
        ),
    ]
    shown = [e for e in events if e.mu_reference is not None and e.volume_m3]
    for name, color, symbol, mine in by_path(shown, names, language):
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": label(name),
                "x": [e.volume_m3 for e in mine],
                "y": [e.mu_reference for e in mine],
                "text": [label(event_words(e, names, language)) for e in mine],
                "hovertemplate": "%{text}<br>"
                + say("apparent friction {friction}", friction="%{y:.3f}")
                + "<extra></extra>",
                "marker": {"color": color, "symbol": symbol, "size": 7, "opacity": 0.8},
            }
        )
    inside = "" if view.scatter is None else _inside(view, shown, language)
    lacking = len(events) - len(shown)
    return Figure(
        "friction",
        say("Friction against volume"),
        language.plural(
            "Apparent friction of {n} event against its volume, with the calibrated median and the "
            "bands that hold 50 and 90 % of avalanches.",
            "Apparent friction of {n} events against their volume, with the calibrated median and "
            "the bands that hold 50 and 90 % of avalanches.",
            len(shown),
        ),
        say(
            "Apparent friction is the one whose block, with the model’s effects on its motion, "
            "stops where the record says; what effects on friction and the path itself add to it "
            "is taken off, as it is from the curve. Large avalanches run farther where the curve "
            "falls. The model itself was fitted to the records, not to these points."
        )
        + inside
        + (
            " "
            + language.plural(
                "{n} event has no volume, or no friction stops the block at its record, and is "
                "not shown.",
                "{n} events have no volume, or no friction stops the block at their record, and "
                "are not shown.",
                lacking,
            )
            if lacking
            else ""
        ),
        data,
        layout(
            axis(say("volume (m³)"), type="log", exponentformat="power", dtick=1),
            axis(say("friction μ")),
            height=470,
        ),
    )


def _inside(view: FrictionView, events: Sequence[EventView], language: Language) -> str:
    """How many points lie in the wide band."""
    assert view.scatter is not None
    log_volume = np.log([e.volume_m3 or np.nan for e in events])
    low, high = (np.interp(log_volume, np.log(view.volume), view.scatter[k]) for k in (0, 3))
    mu = np.array([e.mu_reference for e in events], np.float64)
    n = int(np.sum((mu >= low) & (mu <= high)))
    return " " + language.say("{n} of {total} lie in the band of 90 %.", n=n, total=len(events))


def _band(x: Floats, low: Floats, high: Floats, color: str, name: str) -> list[Trace]:
    """A filled band as one closed line."""
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "fill": "toself",
            "fillcolor": color,
            "line": {"width": 0},
            "x": [*x.tolist(), *x[::-1].tolist()],
            "y": [*high.tolist(), *low[::-1].tolist()],
            "name": name,
            "hoverinfo": "skip",
        }
    ]
