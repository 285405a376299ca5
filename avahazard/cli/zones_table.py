"""Zones, speeds and pressures as tables for people."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from avahazard.cli.design_table import DESIGN_COLUMNS, design_cells
from avahazard.cli.output import evenly, table
from avahazard.results.zones import ExceededHere, PeriodDesign, Place, Zone, ZonedPath

BEYOND = "beyond"
SHOWN = 12
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
                design_cells(entry.path_id, _period(found), found.design)
                for entry in entries
                for found in entry.designs
            ],
        )
    )
    console.print(
        table(
            f"Zones by the limits '{first.limits}'",
            ("path", "zone", ">from x m", ">to x m", ">its 5–95 %"),
            [_zone(entry.path_id, zone) for entry in entries for zone in entry.zones],
        )
    )
    periods = [_period(found) for found in first.places[0].by_return_period]
    if len(entries) == 1:
        headings = [f">{what} {period}" for period in periods for what in ("u", "p")]
        console.print(
            table(
                f"{first.path_id}: speed u in m/s and pressure p in kPa exceeded in T years",
                (">x m", ">z m", ">p/year", *headings),
                [_place(place) for place in evenly(first.places, SHOWN)],
            )
        )
    else:
        console.print(
            table(
                "Largest along the path: median, 5 to 95 %",
                ("path", ">T yr", ">u m/s", ">5–95 %", ">p kPa", ">5–95 %"),
                [_largest(e, k) for e in entries for k in range(len(periods))],
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
    cells = [cell for e in entries for zone in e.zones for cell in _zone("", zone)]
    cells += [cell for e in entries for d in e.designs for cell in design_cells("", "", d.design)]
    if any(BEYOND in cell for cell in cells):
        console.print(f"{BEYOND}: past the end of the profile. A longer profile would tell.")


def _zone(path_id: str, zone: Zone) -> tuple[str, ...]:
    name = zone.zone + ("*" if zone.extrapolated else "")
    if zone.to_x_m <= zone.from_x_m:
        start = BEYOND if zone.beyond else "none"
        return (path_id, name, start, "–", _interval(zone))
    end = BEYOND if zone.beyond else f"{zone.to_x_m:.0f}"
    return (path_id, name, f"{zone.from_x_m:.0f}", end, _interval(zone))


def _period(found: ExceededHere | PeriodDesign) -> str:
    return f"{found.return_period_years:g}" + ("*" if found.extrapolated else "")


def _interval(zone: Zone) -> str:
    ends = (zone.to_x_q05_m, zone.to_x_q95_m)
    low, high = (BEYOND if x is None else f"{x:.0f}" for x in ends)
    return f"{low}–{high}"


def _place(place: Place) -> tuple[str, ...]:
    cells = [f"{place.x_m:.0f}", f"{place.elevation_m:.0f}"]
    cells.append(f"{place.p_reach_per_year:.2g}")
    for found in place.by_return_period:
        cells.append(f"{found.speed_m_s.q50:.0f}")
        cells.append(f"{found.pressure_kpa.q50:.0f}")
    return tuple(cells)


def _largest(entry: ZonedPath, k: int) -> tuple[str, ...]:
    found = [place.by_return_period[k] for place in entry.places]
    cells = [entry.path_id, _period(found[0])]
    for values in ([f.speed_m_s for f in found], [f.pressure_kpa for f in found]):
        most = max(values, key=lambda v: v.q50)
        cells += [f"{most.q50:.0f}", f"{most.q05:.0f}–{most.q95:.0f}"]
    return tuple(cells)
