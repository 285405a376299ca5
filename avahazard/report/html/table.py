"""A table of the report as text, cell by cell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from avahazard.report.html.words import amount
from avahazard.report.language import ENGLISH, Language


@dataclass(frozen=True, slots=True)
class HtmlTable:
    """Columns (a name that begins with '>' is set to the right) and rows of text.

    `cards`: on a narrow screen every row becomes a block of its own, with a line for each cell.
    Rows after the first `shown` are folded under the words `folded`; None: no row is.
    """

    key: str
    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    cards: bool = False
    shown: int | None = None
    folded: str = ""

    @property
    def parts(self) -> list[tuple[bool, Sequence[Sequence[str]]]]:
        """The rows that are always seen, and those that are folded, each if there are any."""
        k = len(self.rows) if self.shown is None else self.shown
        parts = [(False, self.rows[:k]), (True, self.rows[k:])]
        return [part for part in parts if part[1]]


def error_text(
    value: float | None, coordinate: str | None = None, language: Language = ENGLISH
) -> str:
    """An error in metres, or H/L in that coordinate; a dash where it is not known."""
    return "–" if value is None else amount(value, coordinate, language=language)
