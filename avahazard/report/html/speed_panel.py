"""Speeds along a path: of every row's median block, or with their spread where zones are known."""

from __future__ import annotations

from avahazard.report.html.content import PathView
from avahazard.report.html.figure import Trace
from avahazard.report.html.style import ROW_COLORS
from avahazard.report.html.words import case, years
from avahazard.report.language import ENGLISH, Language


def speed_traces(view: PathView, language: Language = ENGLISH) -> list[Trace]:
    """Speed in m/s over x; empty where nothing is known of it."""
    if view.zones and view.zones["places"]:
        return _quantiles(view, language)
    cases = [case(row, language) for row in view.rows]
    lines = [(case(line.row, language), line) for line in view.speeds]
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "name": language.say("speed, {case}", case=of),
            "legendgroup": f"row {of}",
            "showlegend": False,
            "x": line.x,
            "y": line.speed,
            "line": {"color": ROW_COLORS[cases.index(of) % len(ROW_COLORS)]},
            "hovertemplate": language.say(
                "{case}: {speed} m/s at x {x} m", case=of, speed="%{y:.1f}", x="%{x:.0f}"
            )
            + "<extra></extra>",
        }
        for of, line in lines
    ]


def _quantiles(view: PathView, language: Language) -> list[Trace]:
    """The 5, 50 and 95 % of the speed of each return period, with the pressure on hover."""
    assert view.zones is not None
    places = view.zones["places"]
    periods = [entry["return_period_years"] for entry in places[0]["by_return_period"]]
    known = [row["return_period_years"] for row in view.rows]
    traces: list[Trace] = []
    for k, period in enumerate(periods):
        color = ROW_COLORS[(known.index(period) if period in known else k) % len(ROW_COLORS)]
        of = years(period, language)
        entries = [place["by_return_period"][k] for place in places]
        for key, width, dash in (("q50", 2.0, "solid"), ("q95", 1.0, "dash"), ("q05", 1.0, "dot")):
            traces.append(
                {
                    "type": "scatter",
                    "mode": "lines",
                    "name": language.say("speed, {case}", case=of),
                    "legendgroup": f"row {of}",
                    "showlegend": False,
                    "x": [place["x_m"] for place in places],
                    "y": _moving([entry["speed_m_s"][key] for entry in entries]),
                    "customdata": [entry["pressure_kpa"][key] for entry in entries],
                    "line": {"color": color, "width": width, "dash": dash},
                    "hovertemplate": language.say(
                        "{case}, {share} %: {speed} m/s, {pressure} kPa at x {x} m",
                        case=of,
                        share=str(int(key[1:])),
                        speed="%{y:.1f}",
                        pressure="%{customdata:.0f}",
                        x="%{x:.0f}",
                    )
                    + "<extra></extra>",
                }
            )
    return traces


def _moving(speeds: list[float]) -> list[float | None]:
    """Speeds up to the first place that is not reached."""
    n = next((i for i, u in enumerate(speeds) if i and not u), len(speeds))
    return [u if i <= n else None for i, u in enumerate(speeds)]
