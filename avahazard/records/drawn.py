"""Paths that were drawn as lines on a map, in the form in which CSV files are read."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.records.errors import RowProblem
from avahazard.records.table import Table
from avahazard.records.terrain_crop import TerrainCrop


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """The lines of a file as rows of `paths.csv` and `profiles.csv`.

    Each with the number of its feature in the place of a line number; the ground around them; and
    what is wrong with them.
    """

    file: str
    paths: Table
    profiles: Table
    terrain: tuple[TerrainCrop, ...]
    problems: tuple[RowProblem, ...]
    notes: tuple[str, ...]
