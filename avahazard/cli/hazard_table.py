"""Bounds of the runout as tables for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console

from avahazard.cli.output import table

BEYOND = "beyond"


def show_bounds(console: Console, rows: Sequence[dict[str, Any]]) -> None:
    """Print the rows of `hazard`, where their volumes come from, and what the intervals mean."""
    console.print(
        table(
            "Runout: x along the path, z elevation; mean, and 5 to 95 %",
            ("path", ">T yr", ">V m3", ">x m", ">x 5–95 %", ">z m", ">z 5–95 %", ">left"),
            [_bounds(row) for row in rows],
        )
    )
    returned = [row for row in rows if "volume_method" in row]
    if returned:
        console.print(
            table(
                "Volumes of the return periods (90 % interval of the estimate)",
                ("path", ">T yr", ">V m3", ">V 5–95 % m3", ">records", "years", ">a year", "fit"),
                [_volume(row) for row in returned],
            )
        )
    for words in dict.fromkeys(row["interval"] for row in rows):
        console.print(f"Interval: {words}.")
    if any(row["p_left_profile"] > 0.0 for row in rows):
        console.print(
            "left: share that ran past the end of the profile; the mean is of those that stopped."
        )
    if any(BEYOND in cell for row in rows for cell in _bounds(row) if isinstance(cell, str)):
        console.print(f"{BEYOND}: past the end of the profile. A longer profile would tell.")
    if any(row["pooled"] for row in returned):
        console.print(
            "pooled: scale and shape of the yearly maxima are those of all paths together."
        )
    if returned:
        console.print(_spans(returned))


def _bounds(row: dict[str, Any]) -> tuple[Any, ...]:
    x, z = row["runout_x_m"], row["runout_elevation_m"]
    held = row["p_not_released"] > 0.5
    return (
        row["path_id"],
        _year(row["return_period_years"]),
        _volume_text(row["volume_m3"]),
        "held" if held else _metres(x["mean"]),
        "–" if held else f"{_metres(x['q05'])}–{_metres(x['q95'])}",
        "held" if held else _metres(z["mean"]),
        "–" if held else f"{_metres(z['q05'])}–{_metres(z['q95'])}",
        "0" if row["p_left_profile"] == 0.0 else f"{row['p_left_profile']:.1%}",
    )


def _volume(row: dict[str, Any]) -> tuple[Any, ...]:
    interval = row["volume_interval_m3"]
    return (
        row["path_id"],
        _year(row["return_period_years"]),
        _volume_text(row["volume_m3"]),
        f"{_volume_text(interval['q05'])}–{_volume_text(interval['q95'])}",
        row["n_records"],
        f"{row['first_year']}–{row['last_year']}",
        f"{row['events_per_year']:.2f}",
        "pooled" if row["pooled"] else "own",
    )


def _spans(rows: Sequence[dict[str, Any]]) -> str:
    """What the rates are, and where the observed years come from."""
    by_source: dict[str, list[str]] = {}
    for row in rows:
        paths = by_source.setdefault(row["years_from"], [])
        if row["path_id"] not in paths:
            paths.append(row["path_id"])
    if len(by_source) == 1:
        sources = next(iter(by_source))
    else:
        sources = "; ".join(f"{source} ({', '.join(ids)})" for source, ids in by_source.items())
    return f"a year: records over years; years: {sources}."


def _year(period: float | None) -> str:
    return "–" if period is None else f"{period:g}"


def _metres(value: float | None) -> str:
    return BEYOND if value is None else f"{value:.0f}"


def _volume_text(volume: float | None) -> str:
    """A volume to three digits: its own error is larger."""
    if volume is None:
        return "any"
    return f"{float(f'{volume:.3g}'):.0f}" if volume < 1e6 else f"{volume:.3g}"
