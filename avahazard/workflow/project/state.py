"""A run of a project under way."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

from avahazard.results.base import Report
from avahazard.store.results import Kind, latest_result
from avahazard.store.session import reading
from avahazard.workflow.project.file import Project

DONE, UP_TO_DATE = "done", "up to date"


@dataclass(slots=True)
class ProjectState:
    """The project, where its files are, and its database.

    `fresh` as soon as a step has found something new; `written` is when the file of the project
    was (seconds, as of files).
    """

    project: Project
    folder: FilePath
    database: str
    report: Report
    fresh: bool = False
    written: float = 0.0


def stored_result(run: ProjectState, kind: Kind, model: str) -> dict[str, Any] | None:
    """What was found last by a model; None where nothing was."""
    with reading(run.database) as session:
        return latest_result(session, kind, model)
