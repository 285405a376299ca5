"""Runs of flow models on the terrain of paths, and the map that is drawn of them."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.notes import Note
from avahazard.results.base import Result, Rows


@dataclass(frozen=True, slots=True)
class SimulatedPath(Result):
    """The runs of a path: how many there are, and were made now; over which ranges, and how far.

    The stops are the shortest and the longest (m along the line), None where nothing moved.
    `seconds` is what a run took, on average; `left` is how many passed the end of the line.
    """

    path_id: str
    engine: str
    n_runs: int
    n_new: int
    friction_min: float
    friction_max: float
    volume_min_m3: float
    volume_max_m3: float
    stop_min_x_m: float | None
    stop_max_x_m: float | None
    left: int
    seconds: float


@dataclass(frozen=True, slots=True)
class Simulations(Result):
    """The runs of all paths, with notes for people."""

    rows: Rows[SimulatedPath]
    notes: tuple[Note, ...] = ()


@dataclass(frozen=True, slots=True)
class SimulationPlan(Result):
    """What `simulate` will take at least, before it refines; nothing is run.

    `seconds_per_run` is that of runs that are stored, else a guess by the number of cells
    (`measured` tells which).
    """

    n_paths: int
    n_runs: int
    n_done: int
    workers: int
    seconds_per_run: float
    measured: bool
    seconds: float
    stored_bytes: int


@dataclass(frozen=True, slots=True)
class MappedBy(Result):
    """A path of a map: by which engine, and its largest annual chance in a cell."""

    path_id: str
    engine: str
    n_runs: int
    chance_max: float


@dataclass(frozen=True, slots=True)
class ChanceMap(Result):
    """A map of annual chances that was written: its file, what it holds, and its paths."""

    model: str
    file: str
    crs: str
    cell_m: float
    bands: tuple[str, ...]
    paths: Rows[MappedBy]
    notes: tuple[Note, ...] = ()
