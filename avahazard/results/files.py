"""The database, files in and out of it, and what synth, demo and run make."""

from dataclasses import field
from typing import Any

from avahazard.notes import Note
from avahazard.records.intake import Count, Guess, UnderstoodColumn
from avahazard.results.base import ABSENT, Result, Rows
from avahazard.results.calibration import Calibration
from avahazard.results.comparison import HeldOutScores
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.hazard import HazardRow


class Created(Result):
    """A database that was made, or was there."""

    database: str
    created: bool


class DatabaseState(Result):
    """The revision of the tables and that of the program; `counts` where the state is `current`."""

    database: str
    state: str
    revision: str | None
    head: str | None
    counts: dict[str, int]


class Upgraded(Result):
    """The revisions that a database went from and to, and the copy that was made before."""

    database: str
    from_: str | None
    to: str | None
    backup: str | None = field(default=None, metadata=ABSENT)


class Recomputed(Result):
    """A model calibrated again: whether its draws are those stored; None where it cannot be."""

    model: str
    identical: bool | None
    why_not: str | None


class Checked(Result):
    """Whether a database is whole, what is wrong with it, and what of it was done again."""

    database: str
    whole: bool
    problems: tuple[str, ...]
    recomputed: Rows[Recomputed] | None = field(default=None, metadata=ABSENT)


class Copied(Result):
    """A database and the file that it was copied to."""

    database: str
    backup: str


class ImportedRecords(Result):
    """Rows by kind."""

    paths: Count
    profiles: Count
    events: Count
    speeds: Count


class Import(Result):
    """What an import did, or would do: how it read each file, and each column of it."""

    dry_run: bool
    files: tuple[str, ...]
    read: tuple[str, ...]
    understood: Rows[UnderstoodColumn]
    records: ImportedRecords
    notes: tuple[str, ...]
    next: Note | None = field(default=None, metadata=ABSENT)


class GuessedColumns(Result):
    """A first `columns.toml` that was written, its guesses, and what they leave open."""

    files: tuple[str, ...]
    written: str
    guesses: Rows[Guess]
    open: tuple[str, ...]


class WrittenReport(Result):
    """A report that was written; `lacking` is missing from it, `notes` are on the model."""

    model: str
    file: str
    bytes: int
    n_paths: int
    n_events: int
    lacking: tuple[Note, ...]
    notes: tuple[Note, ...]
    next: Note | None = field(default=None, metadata=ABSENT)


class Layer(Result):
    """A layer of an exported file."""

    layer: str
    n_features: int
    crs: str | None


class Export(Result):
    """What an export wrote, with notes on what could not be drawn."""

    model: str
    file: str
    layers: Rows[Layer]
    notes: tuple[str, ...]


class SyntheticDataset(Result):
    """A synthetic dataset on disk; `effects` have their strength and true parameters."""

    folder: str
    files: tuple[str, ...]
    seed: int
    effects: dict[str, Any]
    n_paths: int
    n_events: int
    n_left_profile: int
    n_speeds: int


class HiddenEffect(Result):
    """The loop on a synthetic dataset with a hidden effect (`hidden`, by its key).

    `model` is without it; `child` has what the `diagnosis` names, None where it names no single
    effect. `report` and `hazard` are those of the last of them; `files` ends with the records.
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


class Step(Result):
    """One step: `done` or `up to date`; `found` says in words what came of it."""

    step: str
    state: str
    found: str


class ProjectRun(Result):
    """A project: its steps in order, the model that its answers are by, and the files written."""

    project: str
    database: str
    model: str
    steps: Rows[Step]
    files: tuple[str, ...]
    notes: tuple[str, ...]
    next: Note | None = field(default=None, metadata=ABSENT)
