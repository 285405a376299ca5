"""The figures of the paper, drawn from the user's own records and models."""

from __future__ import annotations

from dataclasses import dataclass, field

from avahazard.results.base import ABSENT, Result


@dataclass(frozen=True, slots=True)
class PaperFigure(Result):
    """One figure: its number(s) in the paper, what it `shows`, and the `file` it was drawn to.

    `model` is the one that it belongs to, where it belongs to one. `file` is None where it could
    not be drawn; then `notes` say why.
    """

    figure: str
    shows: str
    model: str | None
    file: str | None
    notes: tuple[str, ...] | None = field(default=None, metadata=ABSENT)
