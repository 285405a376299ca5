"""The brief: what those who decide need, and what the annex says of the same in sentences."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from markupsafe import Markup, escape

from avahazard.arrays import Floats
from avahazard.inference.model.choices import METHODS
from avahazard.notes import Note, grouped, placed
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.report.html.content import PathView, PlanView, ReportContent
from avahazard.report.html.figure import GROUND, INK, VERMILION
from avahazard.report.html.map_figure import TINT, period_words, round_length, terrain_png
from avahazard.report.html.path_figure import shown_end
from avahazard.report.language import plural, say, spoken
from avahazard.report.sentences import change_words, error_words, failure_words, verdict_words
from avahazard.report.tables import farthest_words, past_words
from avahazard.report.words import (
    SIGNIFICANT,
    amount,
    coordinate_words,
    metres,
    paths,
    place,
    share,
    some,
    span,
)
from avahazard.results.comparison import Comparison
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


def conclusion(content: ReportContent) -> list[str]:
    """How far, how sure, and whether something is missing: three sentences."""
    return [_how_far(content), _how_sure(content), _what_lacks(content)]


def _how_far(content: ReportContent) -> str:
    period = shown_period(content)
    rows = [r for r in content.rows if r.design and r.return_period_years == period]
    if flows := [view for view in content.paths if view.plan and view.plan.flow]:
        return say(
            "Where flow comes to once in 10 to 300 years is mapped for {paths}.",
            paths=paths(len(flows)),
        )
    if not rows:
        return say("No design runout was computed.")
    past = [content.names[r.path_id] for r in rows if r.design and r.design.records_beyond]
    values = {"period": f"{period:g}", "paths": paths(len(rows))}
    if past:
        names = spoken().few(past, MOST_NAMES)
        return say(
            "The {period}-year design runout is given for {paths}; recorded avalanches went past "
            "its median on {names}.",
            names=names,
            **values,
        )
    return say(
        "The {period}-year design runout is given for {paths}; no recorded avalanche went past "
        "its median.",
        **values,
    )


def _how_sure(content: ReportContent) -> str:
    found = content.comparison
    if found is None:
        return say("How far the model errs is not known: it was never compared.")
    held = found.held_out.runout
    values = {"crps": amount(held.crps_m, found.coordinate, 0), "share": share(held.coverage_90)}
    if found.coordinate == "mixed":
        return say(
            "On held-out records the mean error of the model (CRPS) is {crps}; {share} of them lie "
            "in the 90 % interval.",
            **values,
        )
    return say(
        "On held-out records the mean error of the model (CRPS) is {crps} of {coordinate}; {share} "
        "of them lie in the 90 % interval.",
        coordinate=coordinate_words(found.coordinate),
        **values,
    )


def _what_lacks(content: ReportContent) -> str:
    if not content.model.diagnostics.converged:
        return say("The chains of the sampler have not converged: every number is provisional.")
    if content.records_changed:
        return say("The records have changed since the model was calibrated: calibrate it again.")
    if content.diagnosis is None:
        return say("Whether an effect is missing is not known: the model was not diagnosed.")
    return verdict_words(content.diagnosis).split(". ")[0].rstrip(".") + "."


def rests_on(content: ReportContent) -> list[str]:
    """The records behind the model."""
    events = content.events
    years = [event.year for event in events if event.year is not None]
    bare = [view.name for view in content.paths if len(view.events) < FEW_EVENTS]
    return some(
        years
        and say(
            "Records of {n} events, {first} to {last}: {volumes} with a volume, {left} beyond "
            "the profile; {speeds} measured speeds.",
            n=len(events),
            first=str(min(years)),
            last=str(max(years)),
            volumes=sum(event.volume_m3 is not None for event in events),
            left=sum(event.left_profile for event in events),
            speeds=content.n_speeds,
        ),
        any(row.extrapolated for row in content.rows)
        and say("Return periods past twice the observed years are extrapolated."),
        0 < len(bare) < len(content.paths)
        and plural(
            "{paths} has fewer than {few} records: its design runout rests on the other paths.",
            "{paths} have fewer than {few} records: their design runouts rest on the other paths.",
            len(bare),
            paths=spoken().few(bare),
            few=FEW_EVENTS,
        ),
    )


def limits(content: ReportContent) -> list[str]:
    """The limits of every report, a line each."""
    flows = any(view.plan and view.plan.flow for view in content.paths)
    return [
        say("The terrain is that of the import, in cells: what is smaller is not in it.")
        if flows
        else say(
            "The avalanche is one block on one line: a runout is a point on that line, not an "
            "outline on the map."
        ),
        say("Dams, new forest and other works are in it only as far as the profile shows them."),
        say(
            "Climate, forest and recording are taken to be the same in the future as in the "
            "observed years."
        ),
        say("Avalanches that nobody recorded are not in the model."),
        say("A report is no permit: the line on the map is for those who know the place."),
    ]


@dataclass(frozen=True, slots=True)
class PathCard:
    """What the brief says of one path: `lines` are its return periods and zones."""

    number: int
    name: str
    picture: Markup
    lines: tuple[tuple[str, str, str, str], ...]
    farthest: str | None
    past: str | None
    mind: tuple[str, ...]


def path_cards(content: ReportContent) -> tuple[list[PathCard], list[str]]:
    """Every path with a profile, and what is to be noted on all of several."""
    period = shown_period(content)
    cards = []
    for number, view in enumerate(content.paths, start=1):
        if view.smooth is None:
            continue
        designs = [(row, row.design) for row in view.rows if row.design is not None]
        shown = next((d for r, d in designs if r.return_period_years == period), None)
        cards.append(
            PathCard(
                number,
                view.name,
                terrain_picture(view, view.plan)
                if view.plan and view.plan.flow
                else profile_picture(view, shown),
                (
                    *(_line(row, design) for row, design in designs),
                    *_average_lines(content, view),
                    *_flow_lines(view, view.smooth),
                    *_zone_lines(view, view.smooth),
                ),
                None if shown is None else farthest_words(shown, metres),
                None if shown is None else past_words(shown),
                tuple(_mind(content, view, shown)),
            )
        )
    if len(cards) < 2:
        return cards, []
    common = [words for words in cards[0].mind if all(words in card.mind for card in cards)]
    return [
        replace(card, mind=tuple(words for words in card.mind if words not in common))
        for card in cards
    ], common


def _line(row: HazardRow, design: Design) -> tuple[str, str, str, str]:
    x, z = design.runout_x_m, design.runout_elevation_m
    period = spoken().number(f"{row.return_period_years:g}") + ("*" if row.extrapolated else "")
    return period, place(x.q50), span(x), place(z.q50)


def _average_lines(content: ReportContent, view: PathView) -> Iterable[tuple[str, str, str, str]]:
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


def _flow_lines(view: PathView, smooth: SmoothProfile) -> Iterable[tuple[str, str, str, str]]:
    """How far the flow comes along the line once in each period."""
    flow = view.plan.flow if view.plan else None
    for period, x in sorted(flow.runouts.items()) if flow else ():
        height = None if x.q50 is None else float(smooth.height(x.q50))
        yield spoken().number(f"{period:g}"), place(x.q50), span(x), place(height)


def _zone_lines(view: PathView, smooth: SmoothProfile) -> Iterable[tuple[str, str, str, str]]:
    """Where each zone ends."""
    for zone in view.zones.zones if view.zones else ():
        if zone.to_x_m <= zone.from_x_m:
            continue
        end = None if zone.beyond else zone.to_x_m
        name = say(zone.zone) + ("*" if zone.extrapolated else "")
        ends = span((zone.to_x_q05_m, zone.to_x_q95_m))
        height = None if end is None else float(smooth.height(end))
        yield name, place(end), ends, place(height)


def _mind(content: ReportContent, view: PathView, shown: Design | None) -> Iterable[str]:
    """What to mind on a path: of its answer, its records and its baseline."""
    if view.plan and view.plan.flow:
        return
    if shown is None:
        yield say("No design runout: the block does not start, or the rate is not known.")
        return
    if shown.p_beyond > LEAST_BEYOND:
        chance = share(shown.p_beyond)
        yield say("Beyond the profile with a probability of {share}.", share=chance)
    if any(row.extrapolated for row in view.rows) or any(
        zone.extrapolated for zone in (view.zones.zones if view.zones else ())
    ):
        yield say("*: an extrapolation, past twice the observed years or the table of volumes.")
    if any(row.pooled for row in view.rows):
        yield say("Few volumes on record: their spread is that of all paths.")
    for failure in content.comparison.where_it_fails if content.comparison else ():
        on_it = failure.axis == "path" and failure.level == view.path.path_id
        if on_it and failure.p_value < SIGNIFICANT and content.comparison:
            bias = amount(failure.bias_m, content.comparison.coordinate, 0)
            yield say("The model fails here: bias {bias} (predicted minus recorded).", bias=bias)
    sides: dict[int, list[str]] = {}
    for row in view.alpha_beta:
        side = _side(row.runout_x_low_m, row.runout_x_high_m, shown.runout_x_m)
        if row.runout_x_m is not None:
            words = f"{metres(row.runout_x_m)} ({say(row.coefficients)})"
            sides.setdefault(side, []).append(words)
    if -1 in sides:
        yield say("The α-β runout is shorter: {places}.", places=", ".join(sides[-1]))
    if 1 in sides:
        yield say("The α-β runout is longer: {places}.", places=", ".join(sides[1]))


def _side(low: float | None, high: float | None, x: PlaceQuantiles) -> int:
    """−1 where α-β with one standard deviation lies short of the 90 %, 1 beyond it, else 0."""
    if high is not None and x.q05 is not None and high < x.q05:
        return -1
    return 1 if low is not None and x.q95 is not None and low > x.q95 else 0


# Pictures that need no script


WIDTH, HEIGHT, PLACES = 300, 130, 60
FOOT, LIFT, UNDER = 10, 5, 14
At = Callable[[float], tuple[float, float]]


def profile_picture(view: PathView, design: Design | None) -> Markup:
    """The profile, the recorded stops, the zones, and the design runout with its 90 %."""
    smooth = view.smooth
    assert smooth is not None
    end = shown_end(view)
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
    for zone in view.zones.zones if view.zones else ():
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
        f'<text x="{WIDTH}" y="{HEIGHT + 11}" text-anchor="end">'
        f"x {metres(end)}</text>"
        f'<text x="0" y="{HEIGHT + 11}">x {metres(smooth.x_min)}</text>'
        f'<text x="4" y="2">z {metres(high)}</text>'
    )
    return _svg(f"0 -8 {WIDTH} {HEIGHT + 8 + UNDER}", words, parts)


def terrain_picture(view: PathView, plan: PlanView) -> Markup:
    """The terrain with the areas that flow comes to, the line, and a scale."""
    ground = plan.ground
    assert ground is not None
    n_rows, n_columns = ground.elevation_m.shape
    wide, high = n_columns * ground.cell_m, n_rows * ground.cell_m
    scale = WIDTH / max(wide, high)
    room = 0.5 * (WIDTH - wide * scale)

    def at(there: float) -> tuple[float, float]:
        east, north = (float(np.interp(there, plan.x, v)) for v in (plan.east, plan.north))
        return room + (east - ground.west_m) * scale, (ground.north_m - north) * scale

    length = round_length(0.3 * wide)
    under = high * scale + 8
    parts = [
        f'<image href="{terrain_png(plan)}" x="{room:.1f}" y="0" width="{wide * scale:.1f}" '
        f'height="{high * scale:.1f}" preserveAspectRatio="none"/>',
        f'<polyline points="{_points(at, plan.x)}" fill="none" stroke="{INK}"/>',
        f'<path d="M{room:.1f} {under}v5h{length * scale:.1f}v-5" fill="none" stroke="{INK}"/>'
        f'<text x="{room + length * scale + 6:.1f}" y="{under + 5}">'
        f"{metres(length)}</text>",
    ]
    for k, (period, color) in enumerate(PERIOD_COLORS.items()):
        down = under + 22 + 15 * k
        parts.append(
            f'<rect x="0" y="{down - 10}" width="12" height="12" fill="{color}" opacity="{TINT}"/>'
            f'<text x="18" y="{down}">{escape(period_words(period))}</text>'
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


def overview_map(content: ReportContent) -> Markup | None:
    """All paths from above with zones, design runouts and a scale; None without one system.

    Degrees are drawn so that a metre is as long both ways in the middle of the map.
    """
    views = [view for view in content.paths if view.plan is not None]
    plans = [view.plan for view in views if view.plan is not None]
    if len(views) < 2 or len({plan.crs for plan in plans}) != 1:
        return None
    east = np.concatenate([plan.east for plan in plans])
    north = np.concatenate([plan.north for plan in plans])
    metre = (1.0, 1.0)
    if plans[0].crs is None:
        metre = (111_320.0 * math.cos(math.radians(float(north.mean()))), 111_320.0)
    wide, high = (float(np.ptp(v)) * m for v, m in zip((east, north), metre, strict=True))
    scale = MAP_WIDTH / max(wide, high / MOST_HIGH)
    left, top = float(east.min()), float(north.max())

    def to_page(plan: PlanView) -> At:
        def at(there: float) -> tuple[float, float]:
            a = float(np.interp(there, plan.x, plan.east))
            b = float(np.interp(there, plan.x, plan.north))
            return (a - left) * metre[0] * scale, (top - b) * metre[1] * scale

        return at

    parts: list[str] = []
    period = shown_period(content)
    for view, plan in zip(views, plans, strict=True):
        at = to_page(plan)
        line = _points(at, plan.x)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{INK}" stroke-width="1.4"/>')
        for zone in view.zones.zones if view.zones else ():
            if zone.to_x_m > zone.from_x_m:
                places = np.linspace(zone.from_x_m, zone.to_x_m, 24)
                parts.append(
                    f'<polyline points="{_points(at, places)}" fill="none" '
                    f'stroke="{escape(zone.color)}" stroke-width="9" opacity="0.35"/>'
                )
        rows = (r.design for r in view.rows if r.design and r.return_period_years == period)
        parts += _design(next(rows, None), float(plan.x[-1]), at, 0.0)
        a, b = at(float(plan.x[0]))
        parts.append(f'<text x="{a + 5:.0f}" y="{b + 4:.0f}">{escape(view.name)}</text>')
    length = round_length(0.25 * MAP_WIDTH / scale)
    bar, under, right = length * scale, high * scale + 28.0, wide * scale
    parts.append(
        f'<path d="M0 {under - 6:.0f}v6h{bar:.0f}v-6" fill="none" stroke="{INK}" stroke-width="2"/>'
        f'<text x="{bar + 8:.0f}" y="{under:.0f}">{metres(length)}</text>'
        f'<path d="M{right:.0f} {under:.0f}v-34l-6 12m6 -12l6 12" fill="none" stroke="{INK}" '
        f'stroke-width="2"/><text x="{right - 22:.0f}" y="{under:.0f}">N</text>'
    )
    room, drawn = MAP_ROOM, high * scale + 3 * MAP_ROOM
    box = f"-{room:.0f} -{room:.0f} {right + 5 * room:.0f} {drawn:.0f}"
    words = say("The paths from above, with their design runouts")
    return _svg(box, words, parts)


# The annex in sentences


@dataclass(frozen=True, slots=True)
class Chapter:
    """One model of the line: its heading and its sentences."""

    model: str
    heading: str
    sentences: tuple[str, ...]


def chapters(content: ReportContent) -> list[Chapter]:
    """The story of the model from its first ancestor; empty where nothing was ever compared."""
    from avahazard.criticism.scoring.held_out import error_fall  # noqa: PLC0415 (slow)

    loop = content.loop
    added = {row.model: row.added for row in content.ladder}
    found = []
    for k, name in enumerate(loop.lineage):
        compared, diagnosis = loop.comparisons.get(name), loop.diagnoses.get(name)
        if compared is None and diagnosis is None:
            continue
        quoted = say("“{name}”", name=name)
        parent = loop.lineage[k - 1] if k else None
        before = loop.comparisons.get(parent or "")
        words: list[str] = []
        if compared is not None and before is not None:
            was, now = (c.held_out.runout.crps_m for c in (before, compared))
            if compared.held_out.parent_crps_m is not None:
                was = compared.held_out.parent_crps_m
            fall = error_fall(before, compared)
            words.append(change_words(was, now, compared.coordinate, fall))
        elif compared is not None:
            words += error_words(compared)[:1]
        if compared is not None and not (diagnosis and diagnosis.where):
            words.append(failure_words(compared))
        if diagnosis is not None:
            words.append(verdict_words(diagnosis))
        if name == loop.lineage[-1]:
            words += _unexplained(compared)
        heading = quoted
        if parent is not None:
            more = spoken().listed([spoken().effect(key) for key in added.get(name, ())])
            heading = say("“{model}”: “{parent}” and {more}", model=name, parent=parent, more=more)
        found.append(Chapter(name, heading, tuple(words)))
    return found


def _unexplained(found: Comparison | None) -> list[str]:
    budget = {} if found is None else {part.source: part.rms_m for part in found.budget}
    if found is None or not budget.get("unexplained"):
        return []
    return [
        say(
            "Unexplained: {size} (rms), beyond errors of the records, scatter and uncertain "
            "parameters.",
            size=amount(budget["unexplained"], found.coordinate, 0),
        )
    ]


def notes_of(content: ReportContent) -> list[str]:
    """The notes on the rows of bounds and on the model, a line for all of one kind."""
    names, model = content.names, content.model.model
    # The brief says these.
    said = (Note("stale", model=model), Note("unconverged", model=model))
    where: dict[Note, dict[str, None]] = {}
    for row in content.rows:
        for note in row.notes:
            if note not in (*said, *content.of_model):
                where.setdefault(note, {})[names.get(row.path_id, row.path_id)] = None
    notes = placed(where, len({row.path_id for row in content.rows}))
    notes += [note for note in content.of_model if note not in said]
    return [spoken().note(note) for note in grouped(notes)]


def every_note(content: ReportContent) -> list[str]:
    """The same notes, each by itself."""
    names = content.names
    notes = [
        note.about(names.get(row.path_id, row.path_id))
        for row in content.rows
        for note in row.notes
        if note not in content.of_model
    ]
    return [spoken().note(note) for note in dict.fromkeys((*notes, *content.of_model))]


def unknown_words(content: ReportContent) -> list[str]:
    """What the records do not say, by count."""
    events = content.events
    total = len(events)
    counts = {
        "volume": sum(e.volume_m3 is None for e in events),
        "date": sum(e.year is None for e in events),
        "left": sum(e.left_profile for e in events),
        "path": sum(e.path_id is None for e in events),
    }
    words = [
        plural("{n} of {total} events has no volume.", "{n} of {total} events have no volume.",
               counts["volume"], total=total),
        plural("{n} of {total} events has no date.", "{n} of {total} events have no date.",
               counts["date"], total=total),
        plural("{n} of {total} events ran beyond its profile: only a least runout is known.",
               "{n} of {total} events ran beyond their profile: only a least runout is known.",
               counts["left"], total=total),
        plural("{n} of {total} events has no path, and so no profile: it is judged by H/L.",
               "{n} of {total} events have no path, and so no profile: they are judged by H/L.",
               counts["path"], total=total),
    ]  # fmt: skip
    return some(
        *(n and text for text, n in zip(words, counts.values(), strict=True)),
        not content.n_speeds
        and say("No speeds were measured: what speed does to friction cannot be seen."),
        *(
            n
            and say("“{name}” is not known for {n} of {total} events.", name=name, n=n, total=total)
            for name, n in content.covariates.items()
        ),
    )


def assumptions(content: ReportContent) -> list[str]:
    """Assumptions of the model, its data and its bounds, beside the limits of every report."""
    speeds = any(view.speeds or view.zones for view in content.paths)
    return some(
        say("Recorded volumes and runouts are taken with the errors that the records state."),
        say("The path is the smoothed profile."),
        METHODS[content.model.method].in_metres
        and say(
            "This model's scatter is in metres of elevation and holds all errors at once: "
            "natural variability, errors of the records and of the model."
        ),
        speeds and not content.speed_limited and no_drag_words(),
        any(view.alpha_beta for view in content.paths)
        and say(
            "The α-β runouts are regressions of other regions' extreme avalanches on the "
            "shape of the ground; they know nothing of the records here. Where these are many, "
            "they weigh more; where they are few, look at both."
        ),
    )


def no_drag_words() -> str:
    """The caveat of every picture of speed by a model without drag."""
    return say(
        "The model has no drag: nothing but friction limits its speeds, so that they and the "
        "pressures are too high where a path is steep and long."
    )


def reading_words(content: ReportContent) -> list[str]:
    """How to read the figures of the paths: of what they hold, once for all."""
    views = content.paths
    rows = [row for view in views for row in view.rows]
    zones, speeds = any(view.zones for view in views), any(view.speeds for view in views)
    return some(
        any(row.design for row in rows)
        and say(
            "Thick bars above the ground: 90 % credible interval of the design runout; the "
            "tick is its median."
        ),
        rows
        and say(
            "Thin lines: 90 % of avalanches of one volume, with their distribution. A bar that "
            "ends at the edge goes on beyond the profile."
        ),
        content.loop.models
        and say(
            "Under the profile every record has a line: the tick is where it stopped, the bar "
            "holds 90 % of where the model shown expects it, the grey one that of its parent."
        ),
        any(view.alpha_beta for view in views)
        and say("Stars: α-β runout with one standard deviation."),
        zones
        and say(
            "The strip at the foot shows the zones. Speeds are those that a year exceeds with "
            "chance 1/T: the median full, 95 % dashed, 5 % dotted; hover for the pressure."
        ),
        speeds
        and not zones
        and say("Speeds are those of the block of median friction at that volume."),
        (zones or speeds) and not content.speed_limited and no_drag_words(),
        any(row.reach for row in rows)
        and say(
            "The lowest panel: the chance that an avalanche comes as far in a year, with its "
            "90 % credible interval."
        ),
    )
