"""The database, and files that go in and out of it."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.results.base import Result, Rows


@dataclass(frozen=True, slots=True)
class Created(Result):
    """A database that was made, or was there."""

    database: str
    created: bool
    state: str


@dataclass(frozen=True, slots=True)
class Counts(Result):
    """Rows of one kind."""

    new: int
    unchanged: int
    updated: int


@dataclass(frozen=True, slots=True)
class ImportedRecords(Result):
    """Rows by kind."""

    paths: Counts
    profiles: Counts
    events: Counts
    speeds: Counts


@dataclass(frozen=True, slots=True)
class Import(Result):
    """What an import did, or would do."""

    dry_run: bool
    files: tuple[str, ...]
    records: ImportedRecords
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class WrittenReport(Result):
    """A report that was written; `lacking` says what is missing from it."""

    model: str
    file: str
    bytes: int
    n_paths: int
    n_events: int
    lacking: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Layer(Result):
    """A layer of an exported file."""

    layer: str
    n_features: int
    crs: str | None


@dataclass(frozen=True, slots=True)
class Export(Result):
    """What an export wrote, with notes on what could not be drawn."""

    model: str
    file: str
    layers: Rows[Layer]
    notes: tuple[str, ...]
