"""The first screen: one sentence and one picture a path, drawn without a script."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from avahazard.report.html.content import Document, PathView, ReportContent
from avahazard.report.html.figure import GROUND, INK, VERMILION
from avahazard.report.html.path_figure import shown_end
from avahazard.report.html.summary import SIGNIFICANT
from avahazard.report.html.words import beyond, interval, metres
from avahazard.report.language import ENGLISH, Language


def reading_words(
    views: Sequence[PathView], *, stops: bool = False, language: Language = ENGLISH
) -> list[str]:
    """How to read the figures of the paths: of what they hold, once for all."""
    say = language.say
    rows = [row for view in views for row in view.rows]
    words = []
    if any(row.get("design") for row in rows):
        words.append(
            say(
                "Thick bars above the ground hold 90 % of what the runout exceeded once in the "
                "return period may be; the tick is its median."
            )
        )
    if rows:
        words.append(
            say(
                "Thin lines hold 90 % of avalanches of one volume (that of the return period, or a "
                "given one), and the humps on them are their distribution; the small tick is their "
                "median. A bar that ends at the edge goes on beyond the profile."
            )
        )
    if stops:
        words.append(
            say(
                "Under the profile every record has a line: the tick is where it stopped, the "
                "bar holds 90 % of where the model shown expects it, the grey one behind it that "
                "of the parent, if it has one."
            )
        )
    if any(view.alpha_beta for view in views):
        words.append(
            say(
                "Stars: the α-β runout, from the shape of the ground alone, with one standard "
                "deviation."
            )
        )
    if any(view.zones for view in views):
        words.append(
            say(
                "The strip at the foot shows the zones. Speeds are those that a year exceeds with "
                "chance 1/T: the median full, 95 % dashed, 5 % dotted; hover for the pressure."
            )
        )
    elif any(view.speeds for view in views):
        words.append(say("Speeds are those of the block of median friction at that volume."))
    if any(row.get("reach") for row in rows):
        words.append(
            say(
                "The lowest panel gives the chance that an avalanche comes as far in a year, and "
                "90 % of what that may be."
            )
        )
    return words


WIDTH, HEIGHT, PLACES = 300, 130, 60
FOOT, LIFT = 8, 5
USUAL_YEARS = 100.0


@dataclass(frozen=True, slots=True)
class PathAnswer:
    """What the first screen says of one path: its number for links, its name, the rest."""

    number: int
    name: str
    picture: Markup | None
    sentence: str


def path_answers(content: ReportContent) -> list[PathAnswer]:
    """Every path with a profile or a design runout."""
    period = shown_period(content)
    return [
        PathAnswer(
            number,
            view.name,
            _picture(view, period, content.language),
            _sentence(content, view, period),
        )
        for number, view in enumerate(content.paths, start=1)
        if view.smooth is not None
    ]


def shown_period(content: ReportContent) -> float | None:
    """The return period of the first screen: that nearest to 100 years; None without any."""
    known = [row["return_period_years"] for row in content.rows if row.get("design")]
    return min(known, key=lambda t: abs(np.log(t / USUAL_YEARS)), default=None)


def _row(view: PathView, period: float | None) -> Document | None:
    return next(
        (r for r in view.rows if r.get("design") and r["return_period_years"] == period), None
    )


def _sentence(content: ReportContent, view: PathView, period: float | None) -> str:
    """How far, how sure, and whether the model fails here."""
    language, say = content.language, content.language.say
    row = _row(view, period)
    words = say("No design runout was computed here.")
    if row is not None and period is not None:
        design = row["design"]
        x, z = design["runout_x_m"], design["runout_elevation_m"]
        if x["q50"] is None:
            words = say(
                "Once in {period} years avalanches run past the end of the profile.",
                period=language.number(f"{period:g}"),
            )
        else:
            sure = interval(x, language)
            if x["q95"] is None:
                past_it = say("{beyond}: past the profile", beyond=beyond(language))
                sure = f"{sure} ({past_it})"
            words = say(
                "Once in {period} years avalanches pass x = {x} ({elevation} above sea level); "
                "90 % sure: {interval}.",
                period=language.number(f"{period:g}"),
                x=metres(x["q50"], language),
                elevation=metres(z["q50"], language),
                interval=sure,
            )
        past, n = design["records_beyond"], design["n_records"]
        if past is not None and n:
            words += " " + language.plural(
                "{n} of {total} records lies past it.",
                "{n} of {total} records lie past it.",
                past,
                total=n,
            )
    return " ".join([words, *_trust(content, view)])


def _trust(content: ReportContent, view: PathView) -> list[str]:
    compared = content.comparison
    if compared is None:
        return []
    language, say = content.language, content.language.say
    words = []
    mine = next((g for g in compared.held_out.groups if g.group == view.path.path_id), None)
    if mine is not None:
        error = metres(mine.crps_m, language)
        words.append(say("Its records, kept back, were missed by {error}.", error=error))
    for failure in compared.where_it_fails:
        on_it = failure.axis == "path" and failure.level == view.path.path_id
        if on_it and failure.p_value < SIGNIFICANT:
            words.append(
                say(
                    "Here the model fails beyond chance: {bias}, predicted less recorded.",
                    bias=language.number(f"{failure.bias_m:+.0f} m"),
                )
            )
    return words


def _picture(view: PathView, period: float | None, language: Language) -> Markup | None:
    """The profile, the recorded stops, and the design runout with its 90 %."""
    smooth = view.smooth
    if smooth is None:
        return None
    end = shown_end(view)
    x = np.linspace(smooth.x_min, end, PLACES)
    y = smooth.height(x)
    low, high = float(np.min(y)), float(np.max(y))

    def at(place: float) -> tuple[float, float]:
        across = (place - smooth.x_min) / (end - smooth.x_min) * WIDTH
        up = (float(smooth.height(place)) - low) / (high - low)
        return across, HEIGHT - FOOT - up * (HEIGHT - FOOT - 14)

    ground = " ".join(f"{a:.1f},{b:.1f}" for a, b in map(at, x.tolist()))
    parts = [
        f'<polygon points="0,{HEIGHT} {ground} {WIDTH},{HEIGHT}" fill="{GROUND}"/>',
        f'<polyline points="{ground}" fill="none" stroke="{INK}" stroke-width="1.2"/>',
    ]
    for event in view.events:
        if event.stop_x_m is not None and smooth.x_min <= event.stop_x_m <= end:
            a, b = at(event.stop_x_m)
            parts.append(f'<path d="M{a:.1f} {b - 4:.1f}v8" stroke="{INK}" stroke-width="0.9"/>')
    row = _row(view, period)
    if row is not None:
        parts += _design(row["design"]["runout_x_m"], end, at)
    words = escape(
        language.say(
            "{path}: the profile, the recorded stops and the design runout", path=view.name
        )
    )
    return Markup(  # noqa: S704 (numbers, and words that are escaped)
        f'<svg viewBox="0 -8 {WIDTH} {HEIGHT + 8}" role="img" aria-label="{words}">'
        + "".join(parts)
        + "</svg>"
    )


def _design(found: Document, last: float, at) -> list[str]:  # type: ignore[no-untyped-def]
    """The band that holds 90 %, above the ground, and the median as a line."""
    if found["q05"] is None:
        return []
    end = last if found["q95"] is None else found["q95"]
    places = [at(v) for v in np.linspace(found["q05"], end, 20).tolist()]
    points = " ".join(f"{a:.1f},{b - LIFT:.1f}" for a, b in places)
    line = f'fill="none" stroke="{VERMILION}"'
    parts = [f'<polyline points="{points}" {line} stroke-width="5" opacity="0.75"/>']
    if found["q50"] is not None:
        a, b = at(found["q50"])
        parts.append(f'<path d="M{a:.1f} {b - 22:.1f}V{b + 3:.1f}" {line} stroke-width="2.2"/>')
    return parts
