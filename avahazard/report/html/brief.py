"""The brief: what those who decide need."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.html.content import PathView, ReportContent
from avahazard.report.language import say, spoken
from avahazard.report.model_tables import failing
from avahazard.report.tables import far_text
from avahazard.report.words import amount, metres, place, share, span
from avahazard.results.hazard import Design, HazardRow, PlaceQuantiles

USUAL_YEARS = 100.0
FEW_EVENTS = 5
MOST_NAMES = 4
LEAST_BEYOND = 0.05
"""Probability beyond the profile from which on the interval has no upper end."""


def shown_period(content: ReportContent) -> float | None:
    """The return period of the brief: that nearest to 100 years; None without any."""
    known = [r.return_period_years for r in content.rows if r.design and r.return_period_years]
    return min(known, key=lambda t: abs(np.log(t / USUAL_YEARS)), default=None)


def passed(content: ReportContent, rows: Iterable[HazardRow]) -> list[str]:
    """The names of the paths on which recorded avalanches went past the median of a row."""
    return [content.names[r.path_id] for r in rows if r.design and r.design.records_beyond]


def few_records(content: ReportContent) -> list[str]:
    """The names of the paths with few records; empty where all have few."""
    bare = [view.name for view in content.paths if len(view.events) < FEW_EVENTS]
    return bare if len(bare) < len(content.paths) else []


Line = tuple[str, str, str, str]
"""A return period, a model or a zone, and its x, the 5 to 95 % of it, and z."""


@dataclass(frozen=True, slots=True)
class PathCard:
    """What the brief says of one path: its design runout `shown`, `lines`, what to `mind`."""

    number: int
    view: PathView
    shown: Design | None
    lines: Sequence[Line]
    mind: Sequence[str]


def path_cards(content: ReportContent) -> tuple[list[PathCard], list[str]]:
    """Every path with a profile, and what is to be noted on all of several."""
    period = shown_period(content)
    cards = []
    for number, view in enumerate(content.paths, start=1):
        if view.smooth is None:
            continue
        designs = [(row, row.design) for row in view.rows if row.design is not None]
        shown = next((d for r, d in designs if r.return_period_years == period), None)
        lines = [_line(row, design) for row, design in designs]
        lines += _average_lines(content, view)
        lines += _flow_lines(view, view.smooth)
        lines += _zone_lines(view, view.smooth)
        cards.append(PathCard(number, view, shown, lines, list(_mind(content, view, shown))))
    if len(cards) < 2:
        return cards, []
    return cards, [words for words in cards[0].mind if all(words in card.mind for card in cards)]


def _line(row: HazardRow, design: Design) -> Line:
    x, z = design.runout_x_m, design.runout_elevation_m
    period = spoken().number(f"{row.return_period_years:g}") + ("*" if row.extrapolated else "")
    return period, place(x.q50), span(x), place(z.q50)


def _average_lines(content: ReportContent, view: PathView) -> Iterable[Line]:
    """The design runout averaged over models, and by each of them with its weight."""
    for row in content.averages:
        if row.path_id != view.path.path_id or row.design is None:
            continue
        period, x, interval, z = _line(row, row.design)
        averaged = say("averaged")
        yield f"{period}, {averaged}", x, interval, z
        for one in row.by_model or ():
            name = f"{one.model} ({spoken().number(f'{one.weight:.2f}')})"
            own = one.runout_x_m
            yield name, place(own.q50), span(own), ""


def _flow_lines(view: PathView, smooth: SmoothProfile) -> Iterable[Line]:
    """How far the flow comes along the line once in each period."""
    for period, x in sorted(view.flow.runouts.items()) if view.flow else ():
        height = None if x.q50 is None else float(smooth.height(x.q50))
        yield spoken().number(f"{period:g}"), place(x.q50), span(x), place(height)


def _zone_lines(view: PathView, smooth: SmoothProfile) -> Iterable[Line]:
    """Where each zone ends."""
    for zone in view.drawn_zones:
        end = None if zone.beyond else zone.to_x_m
        name = say(zone.zone) + ("*" if zone.extrapolated else "")
        ends = span((zone.to_x_q05_m, zone.to_x_q95_m))
        height = None if end is None else float(smooth.height(end))
        yield name, place(end), ends, place(height)


def _mind(content: ReportContent, view: PathView, shown: Design | None) -> Iterable[str]:
    """What to mind on a path: of its answer, its records and its baseline."""
    if view.flow:
        return
    if shown is None:
        if any(row.return_period_years for row in view.rows):
            yield say("No design runout: the block does not start, or the rate is not known.")
        elif content.rows:
            yield say("No design runout has been computed yet.")
        return
    if shown.p_beyond > LEAST_BEYOND:
        chance = share(shown.p_beyond)
        yield say("Beyond the profile with a probability of {share}.", share=chance)
    rows, zones = view.rows, view.drawn_zones
    if any([*(row.extrapolated for row in rows), *(zone.extrapolated for zone in zones)]):
        yield far_text()
    if any(row.pooled for row in rows):
        yield say(
            "Few volumes are recorded: their spread rests on those of all paths, their median on "
            "those of the path."
        )
    found = content.comparison
    for failure in failing(found) if found else ():
        if found and failure.axis == "path" and failure.level == view.path.path_id:
            bias = amount(failure.bias_m, found.coordinate, 0)
            yield say("The model fails here: bias {bias} (predicted minus recorded).", bias=bias)
    yield from _baseline(view, shown.runout_x_m)


def _baseline(view: PathView, x: PlaceQuantiles) -> Iterable[str]:
    """The α-β runouts that with one standard deviation lie outside of the 90 % interval."""
    shorter, longer = [], []
    for row in view.alpha_beta:
        if row.runout_x_m is None:
            continue
        low, high = row.runout_x_low_m, row.runout_x_high_m
        words = f"{metres(row.runout_x_m)} ({say(row.coefficients.capitalize())})"
        if high is not None and x.q05 is not None and high < x.q05:
            shorter.append(words)
        elif low is not None and x.q95 is not None and low > x.q95:
            longer.append(words)
    if shorter:
        yield say("The α-β runout is shorter: {places}.", places=", ".join(shorter))
    if longer:
        yield say("The α-β runout is longer: {places}.", places=", ".join(longer))
