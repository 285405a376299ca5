"""What `synth`, `demo`, `run` and `paper-figures` make."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from avahazard.notes import Note
from avahazard.results.base import ABSENT, Result, Rows
from avahazard.results.calibration import Calibration
from avahazard.results.comparison import HeldOutScores
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.hazard import HazardRow


@dataclass(frozen=True, slots=True)
class MadeWorld(Result):
    """A world on disk; `effects` are those at work, with their strength and true parameters."""

    folder: str
    files: tuple[str, ...]
    seed: int
    effects: dict[str, Any]
    n_paths: int
    n_events: int
    n_left_profile: int
    n_speeds: int


@dataclass(frozen=True, slots=True)
class HiddenEffect(Result):
    """The loop on a world made with an effect (`hidden`, by its key) that no model was told of.

    `model` is without it, `held_out` its scores; `child` has what the `diagnosis` names, None
    where it names no single effect. `report` is that of the last of them, `hazard` its bounds;
    `files` ends with the records.
    """

    database: str
    files: tuple[str, ...]
    report: str
    hidden: dict[str, Any]
    n_paths: int
    model: Calibration
    coordinate: str
    held_out: HeldOutScores
    diagnosis: Diagnosis
    child: Calibration | None
    hazard: Rows[HazardRow]
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Demo(Result):
    """The main job on the twin (calibrations, bounds, files), then a hidden effect: `loop`.

    `twin` says what the data are; `files` are those of the twin, and end with its records.
    """

    database: str
    files: tuple[str, ...]
    twin: str
    model: Calibration
    gibbs: Calibration
    hazard: Rows[HazardRow]
    loop: HiddenEffect
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Step(Result):
    """One step: `done` or `up to date`; `found` says in words what came of it."""

    step: str
    state: str
    found: str


@dataclass(frozen=True, slots=True)
class ProjectRun(Result):
    """A project: its steps in order, the model that its answers are by, and the files written."""

    project: str
    database: str
    model: str
    steps: Rows[Step]
    files: tuple[str, ...]
    notes: tuple[str, ...]
    next: Note | None = field(default=None, metadata=ABSENT)


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
