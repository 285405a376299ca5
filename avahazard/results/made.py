"""What `synth` and `demo` make."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from avahazard.results.base import Result, Rows
from avahazard.results.calibration import Calibration
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
class Demo(Result):
    """The main job on the twin: both calibrations, the bounds, and the files written.

    `twin` says what the data are; `files` ends with these.
    """

    database: str
    files: tuple[str, ...]
    twin: str
    model: Calibration
    gibbs: Calibration
    hazard: Rows[HazardRow]
    notes: tuple[str, ...]
