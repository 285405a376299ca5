"""The rows of `hazard` as tables for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from rich.console import Console

from avahazard.cli.design_table import design_line, show_design
from avahazard.cli.hazard_cells import (
    BEYOND,
    FAR,
    metres_text,
    period_text,
    range_text,
    share_text,
    volume_text,
)
from avahazard.cli.output import table
from avahazard.results.hazard import HazardRow


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
    shown += [cell for row in rows for cell in (*_bounds(row), *_apart(row))]
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
            [_bounds(row) for row in rows],
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
                [_volume(row) for row in returned],
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


def _bounds(row: HazardRow) -> tuple[Any, ...]:
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
    found = [("Interval", row.interval)]
    for part, name in ((row.natural, "natural"), (row.parameters, "parameters")):
        if part is not None:
            found.append((name, part.interval))
    return found


def _volume(row: HazardRow) -> tuple[Any, ...]:
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
        _source(row),
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


def _source(row: HazardRow) -> str:
    if row.volume_source != "records":
        return str(row.volume_source)
    return "pooled" if row.pooled else "own"
