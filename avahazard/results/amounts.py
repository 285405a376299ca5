"""Numbers in the unit of the records: metres, or H/L where that alone is known."""

from __future__ import annotations

RATIO = "h_over_l"
"""The coordinate of records of which H/L alone is known; keys that end in `_m` then hold H/L."""


def unit_of(coordinate: str | None) -> str:
    """The unit of scores in this coordinate of the records."""
    return "H/L" if coordinate == RATIO else "m"


def bare(value: float, coordinate: str | None, digits: int = 1) -> str:
    """A number in the unit of the records, without it; `digits` after the point of metres."""
    return f"{value:.4f}" if coordinate == RATIO else f"{value:.{digits}f}"


def amount(value: float, coordinate: str | None, digits: int = 1) -> str:
    """A number in the unit of the records, and the unit."""
    return f"{bare(value, coordinate, digits)} {unit_of(coordinate)}"
