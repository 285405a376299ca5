"""The brief: what those who decide need, with its pictures as SVG, which need no script."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.html.content import PathView, PlanView, ReportContent
from avahazard.report.html.figure import GROUND, INK, VERMILION
from avahazard.report.html.map_figure import (
    M_PER_DEGREE,
    TINT,
    period_text,
    round_length,
    terrain_png,
)
from avahazard.report.html.path_figure import shown_end
from avahazard.report.language import say, spoken
from avahazard.report.model_tables import failing
from avahazard.report.tables import far_text
from avahazard.report.words import amount, metres, place, share, span
from avahazard.results.hazard import Design, HazardRow, PlaceQuantiles
from avahazard.results.terrain import PERIOD_COLORS

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
        of_period = (row.design for row in view.rows if row.return_period_years == period)
        shown = next(filter(None, of_period), None)
        lines, mind = _lines(content, view, view.smooth), _mind(content, view, shown)
        cards.append(PathCard(number, view, shown, list(lines), list(mind)))
    if len(cards) < 2:
        return cards, []
    return cards, [words for words in cards[0].mind if all(words in card.mind for card in cards)]


def _line(row: HazardRow, design: Design) -> Line:
    x, z = design.runout_x_m, design.runout_elevation_m
    period = spoken().number(f"{row.return_period_years:g}") + ("*" if row.extrapolated else "")
    return period, place(x.q50), span(x), place(z.q50)


def _lines(content: ReportContent, view: PathView, smooth: SmoothProfile) -> Iterable[Line]:
    """The design runouts, also averaged over models; how far flow comes; where zones end."""
    yield from (_line(row, row.design) for row in view.rows if row.design is not None)
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
    for years, come in sorted(view.flow.runouts.items()) if view.flow else ():
        height = None if come.q50 is None else float(smooth.height(come.q50))
        yield spoken().number(f"{years:g}"), place(come.q50), span(come), place(height)
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


WIDTH, HEIGHT, PLACES = 300, 130, 60
FOOT, LIFT, UNDER = 10, 5, 14
At = Callable[[float], tuple[float, float]]


def profile_picture(view: PathView, design: Design | None) -> Markup:
    """The profile, the recorded stops, the zones, and the design runout with its 90 %."""
    smooth = view.smooth
    assert smooth is not None
    end = shown_end(view, smooth)
    x = np.linspace(smooth.x_min, end, PLACES)
    low, high = float(np.min(smooth.height(x))), float(np.max(smooth.height(x)))

    def at(there: float) -> tuple[float, float]:
        across = (there - smooth.x_min) / (end - smooth.x_min) * WIDTH
        up = (float(smooth.height(there)) - low) / (high - low)
        return across, HEIGHT - FOOT - up * (HEIGHT - FOOT - 14)

    ground = _points(at, x)
    parts = [
        f'<polygon points="0,{HEIGHT} {ground} {WIDTH},{HEIGHT}" fill="{GROUND}"/>',
        f'<polyline points="{ground}" fill="none" stroke="{INK}" stroke-width="1.2"/>',
    ]
    for zone in view.drawn_zones:
        a, b = (at(min(v, end))[0] for v in (zone.from_x_m, zone.to_x_m))
        parts.append(
            f'<rect x="{a:.1f}" y="{HEIGHT - 5}" width="{max(b - a, 0):.1f}" height="5" '
            f'fill="{escape(zone.color)}"/>'
        )
    for event in view.events:
        if event.stop_x_m is not None and smooth.x_min <= event.stop_x_m <= end:
            a, b = at(event.stop_x_m)
            parts.append(f'<path d="M{a:.1f} {b - 4:.1f}v8" stroke="{INK}" stroke-width="0.9"/>')
    parts += _design(design, end, at, LIFT)
    words = say("{path}: the profile, the recorded stops and the design runout", path=view.name)
    parts.append(
        f'<text x="{WIDTH}" y="{HEIGHT + 11}" text-anchor="end">x {metres(end)}</text>'
        f'<text x="0" y="{HEIGHT + 11}">x {metres(smooth.x_min)}</text>'
        f'<text x="4" y="2">z {metres(high)}</text>'
    )
    return _svg(f"0 -8 {WIDTH} {HEIGHT + 8 + UNDER}", words, parts)


def terrain_picture(view: PathView) -> Markup:
    """The terrain with the areas that flow comes to, the line, and a scale."""
    plan = view.plan
    assert plan is not None
    ground = plan.ground
    assert ground is not None
    n_rows, n_columns = ground.elevation_m.shape
    wide, high = n_columns * ground.cell_m, n_rows * ground.cell_m
    scale = WIDTH / max(wide, high)
    room = 0.5 * (WIDTH - wide * scale)

    def at(there: float) -> tuple[float, float]:
        east, north = map(float, plan.at(there))
        return room + (east - ground.west_m) * scale, (ground.north_m - north) * scale

    length = round_length(0.3 * wide)
    under = high * scale + 8
    parts = [
        f'<image href="{terrain_png(ground, plan.flow)}" x="{room:.1f}" y="0" '
        f'width="{wide * scale:.1f}" height="{high * scale:.1f}" preserveAspectRatio="none"/>',
        f'<polyline points="{_points(at, plan.x)}" fill="none" stroke="{INK}"/>',
        f'<path d="M{room:.1f} {under}v5h{length * scale:.1f}v-5" fill="none" stroke="{INK}"/>'
        f'<text x="{room + length * scale + 6:.1f}" y="{under + 5}">{metres(length)}</text>',
    ]
    for k, (period, color) in enumerate(PERIOD_COLORS.items()):
        down = under + 22 + 15 * k
        parts.append(
            f'<rect x="0" y="{down - 10}" width="12" height="12" fill="{color}" opacity="{TINT}"/>'
            f'<text x="18" y="{down}">{escape(period_text(period))}</text>'
        )
    words = say("{path}: where flow comes to once in some years", path=view.name)
    return _svg(f"0 0 {WIDTH} {under + 75}", words, parts)


def _svg(box: str, words: str, parts: Iterable[str]) -> Markup:
    return Markup(  # noqa: S704 (numbers, and words that are escaped)
        f'<svg viewBox="{box}" role="img" aria-label="{escape(words)}">{"".join(parts)}</svg>'
    )


def _points(at: At, x: Floats, lift: float = 0.0) -> str:
    return " ".join(f"{a:.1f},{b - lift:.1f}" for a, b in map(at, x.tolist()))


def _design(design: Design | None, last: float, at: At, lift: float) -> list[str]:
    """The band that holds 90 %, and the median as a line across."""
    if design is None or design.runout_x_m.q05 is None:
        return []
    found = design.runout_x_m
    end = last if found.q95 is None else min(found.q95, last)
    points = _points(at, np.linspace(found.q05 or 0.0, end, 20), lift)
    line = f'fill="none" stroke="{VERMILION}"'
    parts = [f'<polyline points="{points}" {line} stroke-width="5" opacity="0.7"/>']
    if found.q50 is not None:
        a, b = at(found.q50)
        mark = f"M{a:.1f} {b - 22:.1f}V{b + 3:.1f}" if lift else f"M{a - 5:.1f} {b:.1f}h10"
        parts.append(f'<path d="{mark}" {line} stroke-width="2.2"/>')
    return parts


MAP_WIDTH, MAP_ROOM, MOST_HIGH = 1000.0, 40.0, 0.62


def overview_map(content: ReportContent, period: float | None) -> Markup | None:
    """All paths from above with zones, runouts of `period` and a scale; None without one system.

    Degrees are drawn so that a metre is as long both ways in the middle of the map.
    """
    drawn = [(view, view.plan) for view in content.paths if view.plan is not None]
    plans = [plan for _, plan in drawn]
    if len(plans) < 2 or len({plan.crs for plan in plans}) != 1:
        return None
    east = np.concatenate([plan.east for plan in plans])
    north = np.concatenate([plan.north for plan in plans])
    metre = (1.0, 1.0)
    if plans[0].crs is None:
        metre = (M_PER_DEGREE * math.cos(math.radians(float(north.mean()))), M_PER_DEGREE)
    wide, high = (float(np.ptp(v)) * m for v, m in zip((east, north), metre, strict=True))
    scale = MAP_WIDTH / max(wide, high / MOST_HIGH)
    left, top = float(east.min()), float(north.max())

    def to_page(plan: PlanView) -> At:
        def at(there: float) -> tuple[float, float]:
            a, b = map(float, plan.at(there))
            return (a - left) * metre[0] * scale, (top - b) * metre[1] * scale

        return at

    parts: list[str] = []
    lines: list[tuple[str, Floats]] = []
    for view, plan in drawn:
        at = to_page(plan)
        line = _points(at, plan.x)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{INK}" stroke-width="1.4"/>')
        for zone in view.drawn_zones:
            places = np.linspace(zone.from_x_m, zone.to_x_m, 24)
            parts.append(
                f'<polyline points="{_points(at, places)}" fill="none" '
                f'stroke="{escape(zone.color)}" stroke-width="9" opacity="0.35"/>'
            )
        rows = (r.design for r in view.rows if r.design and r.return_period_years == period)
        parts += _design(next(rows, None), float(plan.x[-1]), at, 0.0)
        places = np.linspace(plan.x[0], plan.x[-1], 4 * PLACES).tolist()
        lines.append((view.name, np.array([at(x) for x in places])))
    length = round_length(0.25 * MAP_WIDTH / scale)
    bar, under, right = length * scale, high * scale + 28.0, wide * scale
    parts.append(
        f'<path d="M0 {under - 6:.0f}v6h{bar:.0f}v-6" fill="none" stroke="{INK}" stroke-width="2"/>'
        f'<text x="{bar + 8:.0f}" y="{under:.0f}">{metres(length)}</text>'
        f'<path d="M{right:.0f} {under:.0f}v-34l-6 12m6 -12l6 12" fill="none" stroke="{INK}" '
        f'stroke-width="2"/><text x="{right - 22:.0f}" y="{under:.0f}">N</text>'
    )
    parts += _names(lines, right)
    room = MAP_ROOM
    box = f"-{room:.0f} -{room:.0f} {right + 5 * room:.0f} {high * scale + 3 * room:.0f}"
    return _svg(box, say("The paths from above, with their design runouts"), parts)


LETTER, LINE = 8.5, 17.0
"""Room of a letter and of a line of names on the map."""


def _names(lines: Sequence[tuple[str, Floats]], right: float) -> Iterator[str]:
    """The names of lines `[n, 2]`, each at an end of its line where it covers least."""
    taken = np.concatenate([line for _, line in lines])
    for name, line in lines:
        (a, b), (c, d), half = line[0], line[-1], 0.5 * LETTER * len(name)
        ends = [(a + 5.0 + half, b), (a - 5.0 - half, b), (a, b - LINE)]
        ends += [(c + 5.0 + half, d), (c - 5.0 - half, d), (c, d + LINE)]
        middles = np.array(ends)
        covered = np.sum(np.all(abs(taken - middles[:, None]) < (half, 0.9 * LINE), axis=2), axis=1)
        beyond = abs(middles[:, 0] - 0.5 * right) > 0.5 * right + 3.0 * MAP_ROOM - half
        x, y = middles[np.argmin(covered + len(taken) * beyond)]
        own = np.linspace((x - half, y), (x + half, y), 4 * PLACES)
        taken = np.concatenate([taken, own])
        yield f'<text x="{x - half:.0f}" y="{y + 5:.0f}">{escape(name)}</text>'
