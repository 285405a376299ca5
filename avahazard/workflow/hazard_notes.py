"""What goes with the rows of `hazard`: of the model, and of single rows in short."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.message import message
from avahazard.workflow.stored.notes import notes_of_fit

ANY_VOLUME = message("this model's friction is the same for every volume.")


def model_notes(model: FittedModel) -> list[str]:
    """What goes with every row of a model."""
    notes = list(notes_of_fit(model))
    if model.ignores_volume:
        notes.append(ANY_VOLUME)
    return notes


class RowNotes:
    """The notes of single rows, each once, with the paths that it is on."""

    def __init__(self, of_model: Sequence[str]) -> None:
        self._of_model = of_model
        self._where: dict[str, dict[str, None]] = {}
        self._paths: dict[str, None] = {}

    def add(self, row: Mapping[str, Any]) -> None:
        """Take the notes of a row's document."""
        self._paths[row["path_id"]] = None
        for note in row["notes"]:
            if note not in self._of_model:
                self._where.setdefault(note, {})[row["path_id"]] = None

    def in_short(self) -> list[str]:
        """Each note, with its paths where it is not on all."""
        return [
            note if len(mine) == len(self._paths) > 1 else f"{_listed(list(mine))}: {note}"
            for note, mine in self._where.items()
        ]


def _listed(paths: list[str], most: int = 20) -> str:
    more = f" and {len(paths) - most} more" if len(paths) > most else ""
    return f"{', '.join(paths[:most])}{more}"
