"""A table of the report as text, cell by cell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class HtmlTable:
    """Columns (a name that begins with '>' is set to the right) and rows of text.

    `cards`: on a narrow screen every row becomes a block of its own, with a line for each cell.
    """

    key: str
    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    cards: bool = False


def error_text(value: float | None) -> str:
    """An error in metres, a dash where it is not known."""
    return "–" if value is None else f"{value:.1f} m"
