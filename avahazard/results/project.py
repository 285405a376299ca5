"""What a run of a whole project did."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.results.base import Result, Rows


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
