"""Bounds of the runout as tables for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console

from avahazard.cli.output import table
from avahazard.results.hazard import HazardRow, Spread

BEYOND, FAR = "beyond", "*"


def show_bounds(console: Console, rows: Sequence[HazardRow]) -> None:
    """Print the rows of `hazard`: both ways, the volumes, and what the intervals mean."""
    console.print(
        table(
            "(a) Runout of the volume: x along the path, z elevation; mean, 5 to 95 %",
            ("path", ">T yr", ">V m3", ">x m", ">x 5–95 %", ">z m", ">z 5–95 %", ">left"),
            [_bounds(row) for row in rows],
        )
    )
    apart = [row for row in rows if row.natural is not None]
    if apart:
        console.print(
            table(
                "(a) apart: natural variability alone, uncertainty of parameters alone",
                ("path", ">T yr", ">V m3", ">natural x 5–95 %", ">parameters x 5–95 %"),
                [_apart(row) for row in apart],
            )
        )
    mixed = [row for row in rows if row.exceeded is not None]
    if mixed:
        console.print(
            table(
                "(b) Runout exceeded once in T years, all volumes mixed; mean, 5 to 95 %",
                ("path", ">T yr", "", ">x m", ">x 5–95 %", ">z m", ">z 5–95 %"),
                [_exceeded(row) for row in mixed],
            )
        )
    returned = [row for row in rows if row.volume_method is not None]
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
        console.print(
            "left: share that ran past the end of the profile; the mean is of those that stopped."
        )
    cells = [_bounds(row) for row in rows] + [_exceeded(row) for row in mixed]
    cells += [_apart(row) for row in apart]
    if any(BEYOND in cell for line in cells for cell in line if isinstance(cell, str)):
        console.print(f"{BEYOND}: past the end of the profile. A longer profile would tell.")
    if any(row.pooled for row in returned):
        console.print(
            "pooled: few volumes on the path; scale and shape lean on those of all paths."
        )
    observed = [row for row in returned if row.years_from is not None]
    if observed:
        console.print(_spans(observed))
    if any(row.extrapolated for row in rows):
        console.print(f"{FAR}: an extrapolation, as the record is under half of T (or see fit).")


def _bounds(row: HazardRow) -> tuple[Any, ...]:
    x, z = row.runout_x_m, row.runout_elevation_m
    held = row.p_not_released > 0.5
    return (
        row.path_id,
        _period(row),
        _volume_text(row.volume_m3),
        "held" if held else _metres(x.mean),
        "–" if held else _range(x),
        "held" if held else _metres(z.mean),
        "–" if held else _range(z),
        "0" if row.p_left_profile == 0.0 else f"{row.p_left_profile:.1%}",
    )


def _apart(row: HazardRow) -> tuple[Any, ...]:
    parts = (row.natural, row.parameters)
    return (
        row.path_id,
        _period(row),
        _volume_text(row.volume_m3),
        *("–" if part is None else _range(part.runout_x_m) for part in parts),
    )


def _exceeded(row: HazardRow) -> tuple[Any, ...]:
    assert row.exceeded is not None
    x, z = row.exceeded.runout_x_m, row.exceeded.runout_elevation_m
    return (
        row.path_id,
        _period(row),
        "",
        _metres(x.mean),
        _range(x),
        _metres(z.mean),
        _range(z),
    )


def _intervals(row: HazardRow) -> list[tuple[str, str]]:
    """What each interval of a row is."""
    found = [("Interval (a)", row.interval)]
    for part, name in (
        (row.natural, "natural"),
        (row.parameters, "parameters"),
        (row.exceeded, "Interval (b)"),
    ):
        if part is not None:
            found.append((name, part.interval))
    return found


def _volume(row: HazardRow) -> tuple[Any, ...]:
    interval = row.volume_interval_m3
    assert interval is not None
    return (
        row.path_id,
        _period(row),
        _volume_text(row.volume_m3),
        f"{_volume_text(interval.q05)}–{_volume_text(interval.q95)}",
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


def _period(row: HazardRow) -> str:
    period = row.return_period_years
    mark = FAR if row.extrapolated else ""
    return "–" if period is None else f"{period:g}{mark}"


def _range(spread: Spread) -> str:
    return f"{_metres(spread.q05)}–{_metres(spread.q95)}"


def _metres(value: float | None) -> str:
    return BEYOND if value is None else f"{value:.0f}"


def _volume_text(volume: float | None) -> str:
    """A volume to three digits: its own error is larger."""
    if volume is None:
        return "any"
    if volume < 1e6:
        return f"{float(f'{volume:.3g}'):.0f}"
    return f"{volume:.2e}".replace("e+0", "e")
