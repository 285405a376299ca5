"""Tables of paths, design runouts and zones, each described once: terminal and report show it."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from typing import Any, TypeVar

from avahazard.report.language import say, spoken
from avahazard.report.words import cubic, digits, integer, number, place, share, some, span
from avahazard.results.hazard import Design, HazardRow, PathVolumes, Quantiles, Zone, ZonedPath
from avahazard.results.terrain import PathSummary, TerrainRunout

R = TypeVar("R")
Column = tuple[str, Callable[[Any], object]]
"""A heading, set to the right where it begins with '>', and what is shown of a row."""
Names = Mapping[str, str]
NO_NAMES: Names = {}
HazardRows = Sequence[HazardRow]


@dataclass(frozen=True, slots=True)
class Table:
    """Columns (a heading that begins with '>' is set to the right) and rows of text.

    `legend`: sentences on how to read it. `cards`: on a narrow screen every row becomes a block of
    its own, with a line for each cell. Rows after the first `shown` are folded under the words
    `folded`; None: no row is.
    """

    key: str
    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    legend: Sequence[str] = ()
    cards: bool = False
    shown: int | None = None
    folded: str = ""


def made(
    key: str,
    title: str,
    columns: Sequence[Column],
    rows: Iterable[Any],
    legend: Sequence[str] = (),
    **more: Any,
) -> Table:
    """The table of the rows, by what each column shows of one; `more` are fields of `Table`.

    Numbers are written in the language, None as a dash. A column after the first that shows
    nothing of any row is left out.
    """
    values = [[show(row) for _, show in columns] for row in rows]
    empty = {k for k in range(1, len(columns)) if values and all(v[k] is None for v in values)}
    kept = [k for k in range(len(columns)) if k not in empty]
    cells = [[cell(row[k]) for k in kept] for row in values]
    return Table(key, title, [columns[k][0] for k in kept], cells, legend, **more)


def cell(value: object) -> str:
    """A value for people: four digits where they are enough, None as a dash."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return say("yes") if value else say("no")
    if isinstance(value, float):
        return number(value)
    return str(value)


def _path(names: Names, of: Callable[[Any], Any] = lambda r: r) -> Column:
    return say("path"), lambda r: names.get(of(r).path_id, of(r).path_id)


def _years(of: Callable[[Any], Any] = lambda r: r) -> Column:
    return ">" + say("T, years"), lambda r: _period(of(r))


def _period(row: Any) -> str | None:
    """The return period of a row, marked where it is an extrapolation."""
    if row.return_period_years is None:
        return None
    return spoken().number(f"{row.return_period_years:g}") + ("*" if row.extrapolated else "")


def far_text() -> str:
    """What the mark of an extrapolation says."""
    return say("*: an extrapolation, past twice the observed years or the table of volumes.")


def _intervals(rows: Iterable[Any]) -> Iterable[str]:
    """What the intervals of the rows hold, each once."""
    return dict.fromkeys(spoken().note(row.interval) + "." for row in rows)


def _some(value: float) -> str | None:
    return share(value) if value else None


def farthest_text(design: Design, written: Callable[[float | None], str] = place) -> str | None:
    """Where the farthest record stopped, as `written`, and its date."""
    found = design.farthest_record
    if found is None:
        return None
    at, date = written(found.runout_x_m), found.date
    if date is None:
        return at
    return f"{at} ({date[:4] if spoken().plain else spoken().date(date)})"


def past_text(design: Design) -> str | None:
    """How many of the records lie past the median."""
    n, total = design.records_beyond, design.n_records
    return None if n is None or not total else say("{n} of {total}", n=n, total=total)


def design_table(rows: HazardRows | Sequence[ZonedPath], names: Names = NO_NAMES) -> Table:
    """The answer for each return period, and what the records say of it."""
    found: list[tuple[Any, Any]] = []
    for row in rows:
        # What has a design runout for a return period: a part of a zoned path, or the row itself.
        of_row = row.designs if isinstance(row, ZonedPath) else (row,)
        found += [(row, one) for one in of_row if one.return_period_years is not None]
    designs = [one.design for _, one in found if one.design is not None]

    def of(show: Callable[[Design], object]) -> Callable[[Any], object]:
        return lambda r: None if r[1].design is None else show(r[1].design)

    def x(answer: tuple[Any, Any]) -> str:
        row, design = answer[0], answer[1].design
        if design is not None:
            return place(design.runout_x_m.q50)
        return say("not released") if row.p_not_released > 0.5 else say("rate unknown")

    columns = (
        _path(names, itemgetter(0)),
        _years(itemgetter(1)),
        (">x, m", x),
        (">5–95 %", of(lambda d: span(d.runout_x_m))),
        (">z, m", of(lambda d: place(d.runout_elevation_m.q50))),
        (">5–95 %", of(lambda d: span(d.runout_elevation_m))),
        (">" + say("beyond"), of(lambda d: _some(d.p_beyond))),
        (">" + say("records past it"), of(past_text)),
        (say("farthest record, m"), of(farthest_text)),
    )
    legend = some(
        designs
        and say(
            "x: horizontal distance along the path from its top; z: elevation there. Median "
            "and 90 % credible interval of the place that avalanches pass once in T years (in "
            "a year with chance 1/T)."
        ),
        *_intervals(designs),
        any(design.p_beyond for design in designs)
        and say("beyond: probability that it lies past the end of the profile."),
        any(one.extrapolated for _, one in found) and far_text(),
    )
    title = say("Design runout: exceeded once in T years by avalanches of all volumes")
    return made("design", title, columns, found, legend, cards=True)


def models_table(rows: HazardRows, names: Names = NO_NAMES) -> Table:
    """What each of the averaged models says of a row."""
    each = [(row, one) for row in rows for one in row.by_model or ()]
    columns = (
        _path(names, itemgetter(0)),
        _years(itemgetter(0)),
        (">V, m³", lambda r: cubic(r[0].volume_m3)),
        (say("model"), lambda r: r[1].model),
        (">" + say("weight"), lambda r: digits(r[1].weight, ".2f")),
        (">x, m", lambda r: place(r[1].runout_x_m.q50)),
        (">5–95 %", lambda r: span(r[1].runout_x_m)),
    )
    return made("models", say("By model: what is averaged"), columns, each, cards=True)


def points_table(rows: HazardRows, names: Names = NO_NAMES) -> Table | None:
    """The median design runouts on the map; None where no path has coordinates."""
    found = [row for row in rows if row.design is not None and row.design.point is not None]

    def at(row: Any, key: str) -> str:
        point = row.design.point
        return spoken().number(f"{getattr(point, key):.{5 if abs(point.x) <= 180.0 else 0}f}")

    columns = (
        _path(names),
        _years(),
        (">" + say("east"), lambda r: at(r, "x")),
        (">" + say("north"), lambda r: at(r, "y")),
        (say("coordinates"), lambda r: r.design.point.crs),
    )
    title = say("Median of the design runout on the map")
    return made("points", title, columns, found) if found else None


def volume_runout_table(rows: HazardRows, names: Names = NO_NAMES) -> Table:
    """Where avalanches of one volume stop: that of a return period, or a given one."""

    def of(
        show: Callable[[HazardRow], object], none: object = None
    ) -> Callable[[HazardRow], object]:
        return lambda r: none if r.p_not_released > 0.5 else show(r)

    columns = (
        _path(names),
        _years(),
        (">V, m³", lambda r: cubic(r.volume_m3)),
        (">x, m", of(lambda r: place(r.runout_x_m.q50), say("not released"))),
        (">5–95 %", of(lambda r: span(r.runout_x_m))),
        (">z, m", of(lambda r: place(r.runout_elevation_m.q50))),
        (">5–95 %", of(lambda r: span(r.runout_elevation_m))),
        (">" + say("beyond"), lambda r: _some(r.p_left_profile)),
    )
    legend = some(
        say("Median, and 5 to 95 % of the runouts of avalanches of the volume V."),
        any(row.return_period_years is not None for row in rows)
        and say(
            "The median for the volume of T years is no design runout: it is passed more often "
            "than once in T years, as smaller avalanches with little friction come as far."
        ),
        *_intervals(rows),
        any(row.p_left_profile for row in rows)
        and say("beyond: share of them that run past the end of the profile."),
        any(row.extrapolated for row in rows) and far_text(),
    )
    title = say("Runout of avalanches of one volume")
    return made("volume", title, columns, rows, legend, cards=True)


def apart_table(rows: HazardRows, names: Names = NO_NAMES) -> Table | None:
    """Natural variability and the uncertainty of the parameters apart; None where not computed."""
    found = [row for row in rows if row.natural is not None and row.parameters is not None]
    columns: tuple[Column, ...] = (
        _path(names),
        _years(),
        (">V, m³", lambda r: cubic(r.volume_m3)),
        (">" + say("x, natural variability"), lambda r: span(r.natural.runout_x_m)),
        (">" + say("x, parameters"), lambda r: span(r.parameters.runout_x_m)),
    )
    parts = [part for row in found for part in (row.natural, row.parameters) if part is not None]
    legend = list(_intervals(parts))
    title = say("Runout of one volume: natural variability and parameters apart, 5–95 %")
    return made("apart", title, columns, found, legend) if found else None


def period_volumes_table(rows: HazardRows, names: Names = NO_NAMES) -> Table | None:
    """Volumes of the return periods, and what they rest on; None without return periods."""
    found = [row for row in rows if row.volume_interval_m3 is not None]

    def origin(row: HazardRow) -> str:
        if row.volume_source != "records":
            return str(row.volume_source)
        return say("all paths") if row.pooled else say("this path")

    columns: tuple[Column, ...] = (
        _path(names),
        _years(),
        (">V, m³", lambda r: cubic(r.volume_m3)),
        (">5–95 %", lambda r: _volumes(r.volume_interval_m3.q05, r.volume_interval_m3.q95)),
        (">" + say("records"), lambda r: r.n_records),
        (say("years"), lambda r: None if r.first_year is None else f"{r.first_year}–{r.last_year}"),
        (">" + say("events a year"), lambda r: digits(r.events_per_year, ".2f")),
        (say("spread from"), origin),
    )
    legend = some(
        any(row.pooled for row in found)
        and say(
            "all paths: few volumes on the path; their spread rests on those of all paths, their "
            "median on its own."
        )
    )
    observed = {(str(r.years_from), r.path_id): None for r in found if r.years_from is not None}
    for source, of in groupby(sorted(observed), key=itemgetter(0)):
        few = spoken().few([names.get(path_id, path_id) for _, path_id in of])
        legend.append(say("Years: {source} ({paths}).", source=say(source), paths=few))
    title = say("Volumes of the return periods, with the 90 % credible interval")
    return made("volumes", title, columns, found, legend) if found else None


def _volumes(low: float, high: float) -> str:
    return f"{cubic(low)}–{cubic(high)}"


def volumes_table(entries: Sequence[PathVolumes]) -> Table:
    """Return levels of the volumes of each path."""
    rows = [(entry, level) for entry in entries for level in entry.levels]
    columns = (
        _path(NO_NAMES, itemgetter(0)),
        _years(itemgetter(1)),
        (">V, m³", lambda r: cubic(r[1].volume_m3)),
        (">5–95 %", lambda r: _volumes(r[1].q05_m3, r[1].q95_m3)),
    )
    legend = some(
        *(f"{entry.path_id}: {entry.method}." for entry in entries),
        any(level.extrapolated for _, level in rows) and far_text(),
    )
    title = "Volumes of the return periods, with the 90 % credible interval"
    return made("volumes", title, columns, rows, legend)


def zones_table(entries: Sequence[ZonedPath], names: Names = NO_NAMES) -> Table | None:
    """The zones of each path; None where none were drawn."""
    rows = [(entry, zone) for entry in entries for zone in entry.zones]
    if not rows:
        return None

    def start(zone: Zone) -> str:
        if zone.to_x_m > zone.from_x_m:
            return place(zone.from_x_m)
        return say("beyond") if zone.beyond else say("none")

    def end(zone: Zone) -> str | None:
        reached = zone.to_x_m > zone.from_x_m
        return place(None if zone.beyond else zone.to_x_m) if reached else None

    columns = (
        _path(names, itemgetter(0)),
        (say("zone"), lambda r: say(r[1].zone) + ("*" if r[1].extrapolated else "")),
        (">" + say("from x, m"), lambda r: start(r[1])),
        (">" + say("to x, m"), lambda r: end(r[1])),
        (">5–95 %", lambda r: span((r[1].to_x_q05_m, r[1].to_x_q95_m))),
    )
    density = entries[0].density_kg_m3
    legend = some(
        say("Limits: {limits}.", limits=say(entries[0].limits)),
        say(
            "Pressure is ρu² with a density of {mean} ± {sd} kg/m³. Speeds and pressures: "
            "{interval}.",
            mean=f"{density.mean:.0f}",
            sd=f"{density.sd:.0f}",
            interval=spoken().note(entries[0].interval),
        ),
        any(zone.extrapolated for _, zone in rows) and far_text(),
    )
    return made("zones", say("Zones"), columns, rows, legend)


PLACES_SHOWN = 12
"""Places in the table of speeds of one path."""


def speeds_table(entries: Sequence[ZonedPath]) -> Table:
    """Speeds and pressures: at places of one path, of several the largest along each."""
    first = entries[0].places[0].by_return_period
    if len(entries) > 1:

        def largest(entry: ZonedPath, k: int, key: str) -> Quantiles:
            found: list[Quantiles] = [getattr(h.by_return_period[k], key) for h in entry.places]
            return max(found, key=lambda value: value.q50)

        rows = [
            (entry, found, largest(entry, k, "speed_m_s"), largest(entry, k, "pressure_kpa"))
            for entry in entries
            for k, found in enumerate(first)
        ]
        several = (
            _path(NO_NAMES, itemgetter(0)),
            _years(itemgetter(1)),
            (">u, m/s", lambda r: integer(r[2].q50)),
            (">5–95 %", lambda r: span((r[2].q05, r[2].q95))),
            (">p, kPa", lambda r: integer(r[3].q50)),
            (">5–95 %", lambda r: span((r[3].q05, r[3].q95))),
        )
        title = "Largest speed u and pressure p along each path"
        return made("speeds", title, several, rows)

    def median(k: int, key: str) -> Callable[[Any], object]:
        return lambda p: f"{getattr(p.by_return_period[k], key).q50:.0f}"

    columns: list[Column] = [
        (">x, m", lambda p: place(p.x_m)),
        (">z, m", lambda p: place(p.elevation_m)),
        (">p/year", lambda p: digits(p.p_reach_per_year, ".2g")),
    ]
    for k, found in enumerate(first):
        for sign, key in (("u", "speed_m_s"), ("p", "pressure_kpa")):
            columns.append((f">{sign} {_period(found)}", median(k, key)))
    where = entries[0].path_id
    title = f"{where}: median speed u (m/s) and pressure p (kPa) exceeded once in T years"
    legend = ["p/year: chance that an avalanche comes so far in a year."]
    shown = thinned(entries[0].places, PLACES_SHOWN)
    return made("speeds", title, columns, shown, legend)


def thinned(rows: Sequence[R], n: int) -> list[R]:
    """About `n` of the rows, at equal distances, with the first and the last."""
    last = len(rows) - 1
    return [rows[i] for i in sorted({round(k * last / n) for k in range(n + 1)})]


def alpha_beta_table(rows: Sequence[TerrainRunout], names: Names = NO_NAMES) -> Table | None:
    """The α-β runouts of the paths; None where there are none."""

    def known(show: Callable[[TerrainRunout], object]) -> Callable[[TerrainRunout], object]:
        return lambda r: None if r.beta_deg is None else show(r)

    columns = (
        _path(names),
        (say("by"), lambda r: say(r.coefficients.capitalize())),
        (">β, °", lambda r: digits(r.beta_deg, ".1f") or say("no β-point")),
        (">" + say("β at x, m"), known(lambda r: place(r.beta_x_m))),
        (">α, °", lambda r: digits(r.alpha_deg, ".1f")),
        (">" + say("± sd, °"), known(lambda r: digits(r.alpha_sd_deg, "g"))),
        (">x, m", known(lambda r: place(r.runout_x_m))),
        (">" + say("± 1 sd"), known(lambda r: span((r.runout_x_low_m, r.runout_x_high_m)))),
    )
    sources = {row.coefficients: row.source for row in rows}
    # Names of papers and programs are English.
    english = sources.items() if spoken().code == "en" else ()
    legend = [f"{name.capitalize()}: {text}." for name, text in english]
    title = say("α-β: extreme runout by regression on the terrain alone")
    return made("alpha-beta", title, columns, rows, legend) if rows else None


def paths_table(rows: Sequence[PathSummary], names: Names = NO_NAMES) -> Table:
    """The paths, their profiles and their records."""
    sections = {"channelled": say("channelled"), "open": say("open")}

    def volumes(row: PathSummary) -> str | None:
        low, high = row.volume_min_m3, row.volume_max_m3
        return None if low is None or high is None else _volumes(low, high)

    def size(key: str) -> Callable[[PathSummary], object]:
        return lambda r: None if getattr(r, key) is None else place(getattr(r, key))

    columns = (
        _path(names),
        (say("section"), lambda r: sections.get(r.section or "", r.section)),
        (">" + say("top, m"), size("top_m")),
        (">" + say("drop, m"), size("drop_m")),
        (">" + say("length, m"), size("length_m")),
        (">" + say("events"), lambda r: r.n_events),
        (">" + say("beyond"), lambda r: r.n_left_profile or None),
        (say("years"), lambda r: None if r.first_year is None else f"{r.first_year}–{r.last_year}"),
        (">" + say("volumes, m³"), volumes),
    )
    left = any(row.n_left_profile for row in rows)
    legend = some(left and say("beyond: events that ran past the end of the profile."))
    return made("paths", say("Paths"), columns, rows, legend)
