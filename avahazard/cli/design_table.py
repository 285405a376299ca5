"""Design runouts, and the records beside them, as tables for people."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from avahazard.cli.hazard_cells import metres_text, period_text, range_text, share_text
from avahazard.cli.output import table
from avahazard.results.hazard import Design, HazardRow

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
