"""Runouts, zones and the plan of a run as tables for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from rich.console import Console

from avahazard.cli.output import evenly, table
from avahazard.notes import counted
from avahazard.results.hazard import Design, HazardPlan, HazardRow, PlaceQuantiles, Spread
from avahazard.results.zones import ExceededHere, PeriodDesign, Place, Zone, ZonedPath

BEYOND, FAR = "beyond", "*"


def period_text(row: HazardRow) -> str:
    """The return period in years, marked where it is an extrapolation."""
    period = row.return_period_years
    mark = FAR if row.extrapolated else ""
    return "–" if period is None else f"{period:g}{mark}"


def range_text(spread: Spread | PlaceQuantiles) -> str:
    """5 to 95 % of a place."""
    return f"{metres_text(spread.q05)}–{metres_text(spread.q95)}"


def share_text(value: float) -> str:
    """A share of draws in percent."""
    return "0" if value == 0.0 else f"{value:.1%}"


def metres_text(value: float | None) -> str:
    """Whole metres, or a word for places past the end of the profile."""
    return BEYOND if value is None else f"{value:.0f}"


def volume_text(volume: float | None) -> str:
    """A volume to three digits: its own error is larger."""
    if volume is None:
        return "any"
    if volume < 1e6:
        return f"{float(f'{volume:.3g}'):.0f}"
    return f"{volume:.2e}".replace("e+0", "e")


DESIGN_COLUMNS = ("path", ">T yr", ">x m", ">x 5–95 %", ">z m", ">z 5–95 %", ">p beyond")


def show_design(console: Console, rows: Sequence[tuple[HazardRow, Design | None]]) -> None:
    """The answer for each return period, and what the records say of it."""
    console.print(
        table(
            "Design runout: exceeded once in T years, by avalanches of all volumes",
            DESIGN_COLUMNS,
            [design_line(row, found) for row, found in rows],
        )
    )
    found = [(row, design) for row, design in rows if design is not None]
    if not found:
        return
    on_map = any(design.point is not None for _, design in found)
    console.print(
        table(
            "Records past the median, and the farthest one",
            ("path", ">T yr", ">records past it", ">farthest x m", "date")
            + ((">east", ">north") if on_map else ()),
            [_beside(row, design, on_map) for row, design in found],
        )
    )
    console.print(
        "x: horizontal distance along the path from its top; z: elevation of that place; the "
        "median, and 5 to 95 % of each by itself (far is low)."
    )
    for words in dict.fromkeys(design.interval for _, design in found):
        console.print(f"Interval: {words}.")
    console.print("p beyond: share of the draws past the end of the profile.")
    for system in dict.fromkeys(d.point.crs for _, d in found if d.point is not None):
        console.print(f"east, north: of the median, in {system}.")


def design_line(row: HazardRow, found: Design | None) -> tuple[str, ...]:
    """The line of one path and return period, under `DESIGN_COLUMNS`."""
    if found is None:
        why = "held" if row.p_not_released > 0.5 else "unknown"
        return (row.path_id, period_text(row), why, "–", why, "–", "–")
    return design_cells(row.path_id, period_text(row), found)


def design_cells(path_id: str, period: str, found: Design) -> tuple[str, ...]:
    """A line of a table of design runouts, under `DESIGN_COLUMNS`."""
    x, z = found.runout_x_m, found.runout_elevation_m
    return (
        path_id,
        period,
        metres_text(x.q50),
        range_text(x),
        metres_text(z.q50),
        range_text(z),
        share_text(found.p_beyond),
    )


def _beside(row: HazardRow, found: Design, on_map: bool) -> tuple[str, ...]:
    farthest, point = found.farthest_record, found.point
    past = "–" if found.records_beyond is None else str(found.records_beyond)
    cells = [
        row.path_id,
        period_text(row),
        f"{past} of {found.n_records}" if found.n_records else "–",
        "–" if farthest is None else metres_text(farthest.runout_x_m),
        "–" if farthest is None else farthest.date or "undated",
    ]
    if on_map:
        digits = 5 if point is not None and abs(point.x) <= 180.0 else 0
        at = (None, None) if point is None else (point.x, point.y)
        cells += ["–" if value is None else f"{value:.{digits}f}" for value in at]
    return tuple(cells)


def show_bounds(
    console: Console, rows: Sequence[HazardRow], failed: Mapping[str, str] = MappingProxyType({})
) -> None:
    """Print the rows of `hazard`: design runouts, those of one volume, and what intervals mean.

    Last, the reasons of the paths that `failed`.
    """
    designed = [(row, row.design) for row in rows if row.return_period_years is not None]
    if designed:
        show_design(console, designed)
        console.print()
    _show_volumes(console, rows)
    shown = [cell for row, found in designed for cell in design_line(row, found)]
    shown += [cell for row in rows for cell in (*_bounds_line(row), *_apart(row))]
    if any(isinstance(cell, str) and BEYOND in cell for cell in shown):
        console.print(f"{BEYOND}: past the end of the profile. A longer profile would tell.")
    if any(row.extrapolated for row in rows):
        console.print(f"{FAR}: an extrapolation, as the record is under half of T (or see fit).")
    if failed:
        console.print(table("Left out", ("path", "why"), list(failed.items())))


def _show_volumes(console: Console, rows: Sequence[HazardRow]) -> None:
    """The runout of avalanches of one volume: that of a return period, or a given one."""
    returned = [row for row in rows if row.volume_method is not None]
    if any(row.return_period_years is not None for row in rows):
        console.print(
            "Another question: where avalanches of the T-year volume V stop. The median of these "
            "is passed more often than once in T years: smaller avalanches with little friction "
            "come as far."
        )
    console.print(
        table(
            "Runout of avalanches of one volume; median, 5 to 95 % of them",
            ("path", ">T yr", ">V m3", ">x m", ">x 5–95 %", ">z m", ">z 5–95 %", ">left"),
            [_bounds_line(row) for row in rows],
        )
    )
    apart = [row for row in rows if row.natural is not None]
    if apart:
        console.print(
            table(
                "Apart: natural variability alone, uncertainty of parameters alone",
                ("path", ">T yr", ">V m3", ">natural x 5–95 %", ">parameters x 5–95 %"),
                [_apart(row) for row in apart],
            )
        )
    if returned:
        console.print(
            table(
                "Volumes of the return periods (90 % interval of the estimate)",
                ("path", ">T yr", ">V m3", ">V 5–95 % m3", ">records", "years", ">a year", "fit"),
                [_volume_line(row) for row in returned],
            )
        )
    for name, words in dict.fromkeys(pair for row in rows for pair in _intervals(row)):
        console.print(f"{name}: {words}.")
    if any(row.p_left_profile > 0.0 for row in rows):
        console.print("left: share of these avalanches that ran past the end of the profile.")
    if any(row.pooled for row in returned):
        console.print(
            "pooled: few volumes on the path; scale and shape lean on those of all paths."
        )
    observed = [row for row in returned if row.years_from is not None]
    if observed:
        console.print(_spans(observed))


def _bounds_line(row: HazardRow) -> tuple[Any, ...]:
    x, z = row.runout_x_m, row.runout_elevation_m
    held = row.p_not_released > 0.5
    return (
        row.path_id,
        period_text(row),
        volume_text(row.volume_m3),
        "held" if held else metres_text(x.q50),
        "–" if held else range_text(x),
        "held" if held else metres_text(z.q50),
        "–" if held else range_text(z),
        share_text(row.p_left_profile),
    )


def _apart(row: HazardRow) -> tuple[Any, ...]:
    parts = (row.natural, row.parameters)
    return (
        row.path_id,
        period_text(row),
        volume_text(row.volume_m3),
        *("–" if part is None else range_text(part.runout_x_m) for part in parts),
    )


def _intervals(row: HazardRow) -> list[tuple[str, str]]:
    """What each interval of the runout of a volume is."""
    found: list[tuple[str, str]] = [("Interval", row.interval)]
    for part, name in ((row.natural, "natural"), (row.parameters, "parameters")):
        if part is not None:
            found.append((name, part.interval))
    return found


def _volume_line(row: HazardRow) -> tuple[Any, ...]:
    interval = row.volume_interval_m3
    assert interval is not None
    return (
        row.path_id,
        period_text(row),
        volume_text(row.volume_m3),
        f"{volume_text(interval.q05)}–{volume_text(interval.q95)}",
        row.n_records,
        "–" if row.first_year is None else f"{row.first_year}–{row.last_year}",
        "–" if row.events_per_year is None else f"{row.events_per_year:.2f}",
        _volume_origin(row),
    )


def _spans(rows: Sequence[HazardRow]) -> str:
    """What the rates are, and where the observed years come from."""
    by_source: dict[str, list[str]] = {}
    for row in rows:
        paths = by_source.setdefault(str(row.years_from), [])
        if row.path_id not in paths:
            paths.append(row.path_id)
    if len(by_source) == 1:
        sources = next(iter(by_source))
    else:
        sources = "; ".join(f"{source} ({', '.join(ids)})" for source, ids in by_source.items())
    return f"a year: records over years; years: {sources}."


def _volume_origin(row: HazardRow) -> str:
    if row.volume_source != "records":
        return str(row.volume_source)
    return "pooled" if row.pooled else "own"


BEYOND = "beyond"
PLACES_SHOWN = 12
"""Places in the table of one path."""


def show_zones(console: Console, entries: Sequence[ZonedPath]) -> None:
    """Print design runouts, zones and largest speeds of every path; of one path those at places."""
    first = entries[0]
    density = first.density_kg_m3
    console.print(
        table(
            "Design runout: exceeded once in T years, by avalanches of all volumes",
            DESIGN_COLUMNS,
            [
                design_cells(entry.path_id, _zone_period(found), found.design)
                for entry in entries
                for found in entry.designs
            ],
        )
    )
    console.print(
        table(
            f"Zones by the limits '{first.limits}'",
            ("path", "zone", ">from x m", ">to x m", ">its 5–95 %"),
            [_zone_line(entry.path_id, zone) for entry in entries for zone in entry.zones],
        )
    )
    periods = [_zone_period(found) for found in first.places[0].by_return_period]
    if len(entries) == 1:
        headings = [f">{what} {period}" for period in periods for what in ("u", "p")]
        console.print(
            table(
                f"{first.path_id}: speed u in m/s and pressure p in kPa exceeded in T years",
                (">x m", ">z m", ">p/year", *headings),
                [_place_line(place) for place in evenly(first.places, PLACES_SHOWN)],
            )
        )
    else:
        console.print(
            table(
                "Largest along the path: median, 5 to 95 %",
                ("path", ">T yr", ">u m/s", ">5–95 %", ">p kPa", ">5–95 %"),
                [_largest_line(e, k) for e in entries for k in range(len(periods))],
            )
        )
    console.print("x: horizontal distance along the path from its top; z: elevation there.")
    console.print(f"u, p: {first.interval}.")
    console.print(
        f"p = ρu² with ρ of {density.mean:g} ± {density.sd:g} kg/m3; p/year: chance that a "
        "year has an avalanche that comes so far."
    )
    far = [zone.extrapolated for e in entries for zone in e.zones]
    if any([*far, *(found.extrapolated for e in entries for found in e.designs)]):
        console.print("*: an extrapolation of the record.")
    cells = [cell for e in entries for zone in e.zones for cell in _zone_line("", zone)]
    cells += [cell for e in entries for d in e.designs for cell in design_cells("", "", d.design)]
    if any(BEYOND in cell for cell in cells):
        console.print(f"{BEYOND}: past the end of the profile. A longer profile would tell.")


def _zone_line(path_id: str, zone: Zone) -> tuple[str, ...]:
    name = zone.zone + ("*" if zone.extrapolated else "")
    if zone.to_x_m <= zone.from_x_m:
        start = BEYOND if zone.beyond else "none"
        return (path_id, name, start, "–", _zone_interval(zone))
    end = BEYOND if zone.beyond else f"{zone.to_x_m:.0f}"
    return (path_id, name, f"{zone.from_x_m:.0f}", end, _zone_interval(zone))


def _zone_period(found: ExceededHere | PeriodDesign) -> str:
    return f"{found.return_period_years:g}" + ("*" if found.extrapolated else "")


def _zone_interval(zone: Zone) -> str:
    ends = (zone.to_x_q05_m, zone.to_x_q95_m)
    low, high = (BEYOND if x is None else f"{x:.0f}" for x in ends)
    return f"{low}–{high}"


def _place_line(place: Place) -> tuple[str, ...]:
    cells = [f"{place.x_m:.0f}", f"{place.elevation_m:.0f}"]
    cells.append(f"{place.p_reach_per_year:.2g}")
    for found in place.by_return_period:
        cells.append(f"{found.speed_m_s.q50:.0f}")
        cells.append(f"{found.pressure_kpa.q50:.0f}")
    return tuple(cells)


def _largest_line(entry: ZonedPath, k: int) -> tuple[str, ...]:
    found = [place.by_return_period[k] for place in entry.places]
    cells = [entry.path_id, _zone_period(found[0])]
    for values in ([f.speed_m_s for f in found], [f.pressure_kpa for f in found]):
        most = max(values, key=lambda v: v.q50)
        cells += [f"{most.q50:.0f}", f"{most.q05:.0f}–{most.q95:.0f}"]
    return tuple(cells)


def show_plan(console: Console, plan: HazardPlan) -> None:
    """Print what a run of `hazard` will take."""
    done = f", {plan.n_done} of them done already" if plan.n_done else ""
    size = f"{counted(plan.n_paths, 'path')}{done}, {counted(plan.n_rows, 'row')}"
    console.print(f"{size}, {plan.n_runs:.3g} runs.")
    console.print(
        f"About {_duration(plan.seconds)} by {plan.engine} with {plan.workers} workers "
        f"({plan.seconds_per_path:.2g} s a path, measured on {plan.measured_paths})."
    )
    for what, need, free in (
        ("Memory", plan.memory_bytes, plan.memory_free_bytes),
        ("Database", plan.stored_bytes, plan.disk_free_bytes),
    ):
        there = "" if free is None else f" of {free / 1e9:.2g} GB free"
        console.print(f"{what}: about {need / 1e9:.2g} GB{there}.")


def _duration(seconds: float) -> str:
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
