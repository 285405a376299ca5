"""Calibrations and their draws, comparisons, diagnoses, and what was found on each path."""

from __future__ import annotations

import datetime as dt
import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import insert, select
from sqlalchemy.orm import Session

from avahazard.records.errors import AvahazardError, did_you_mean
from avahazard.records.plain import plain
from avahazard.store.tables import (
    CalibrationTable,
    ComparisonTable,
    DiagnosisTable,
    DrawChunkTable,
    ModelTable,
    PathResultTable,
    PathRunTable,
    ResultTable,
)


@dataclass(frozen=True, slots=True)
class StoredModel:
    """A model by name, with its last calibration but for the draws, which `calibration` finds.

    `effect_file` is the text of a user's own effects, for the record only; `result` is the document
    of the calibration, empty without one, and `settings` are those of the sampler.
    """

    name: str
    specification: dict[str, Any]
    parent: str | None
    effect_file: str | None
    effect_sha256: str | None
    created: dt.datetime
    calibration: int = 0
    settings: dict[str, Any] = field(default_factory=dict)
    result: dict[str, Any] = field(default_factory=dict)

    @property
    def effects(self) -> tuple[str, ...]:
        """The keys of its effects."""
        return tuple(self.specification["specification"]["effects"])

    @property
    def paths(self) -> tuple[str, ...]:
        """The paths that it was calibrated on; none: all."""
        return tuple(self.specification["paths"])

    @property
    def version(self) -> str | None:
        """The version of the program that calibrated it; None where it was not kept."""
        versions: dict[str, str] = (self.settings.get("made_with") or {}).get("versions", {})
        return versions.get("avahazard")


def save_model(
    session: Session,
    name: str,
    specification: dict[str, Any],
    *,
    parent: str | None = None,
    effect_file: str | None = None,
) -> None:
    """Store a new model.

    Raises:
        AvahazardError: the name is taken, or the parent is not there.
    """
    refuse_taken_name(session, name)
    if parent is not None:
        load_model(session, parent)
    text = effect_file
    session.add(
        ModelTable(
            name=name,
            specification=plain(specification),
            parent=parent,
            effect_file=text,
            effect_sha256=None if text is None else hashlib.sha256(text.encode()).hexdigest(),
            created=now(),
        )
    )
    session.flush()


def refuse_taken_name(session: Session, name: str) -> None:
    """Refuse a name that a model has already: what was calibrated is never overwritten.

    Raises:
        AvahazardError: the name is taken, empty, or over 200 characters.
    """
    if not 0 < len(name.strip()) <= 200:
        raise AvahazardError("A model needs a name of 1 to 200 characters.")
    if session.scalar(select(ModelTable.id).where(ModelTable.name == name)) is not None:
        raise AvahazardError(
            f"There is a model {name} already.",
            "Take another name: a stored model is kept. `avahazard models` lists them.",
        )


def load_model(session: Session, name: str) -> StoredModel:
    """Return the model `name`.

    Raises:
        AvahazardError: there is none.
    """
    row = session.scalar(select(ModelTable).where(ModelTable.name == name))
    if row is None:
        names = session.scalars(select(ModelTable.name).order_by(ModelTable.id)).all()
        hint = f"Make it: `avahazard calibrate {name}`."
        if names:
            hint = f"{did_you_mean(name, names)}Stored are: {', '.join(names)}."
        raise AvahazardError(f"There is no model {name}.", hint)
    return _stored(session, row)


def load_calibrated(session: Session, name: str) -> StoredModel:
    """Return the model `name` with its calibration.

    Raises:
        AvahazardError: there is no such model, or it has not been calibrated.
    """
    found = load_model(session, name)
    if not found.calibration:
        raise AvahazardError(
            f"The model {name} has no calibration.", "Calibrate it under another name."
        )
    return found


def list_models(session: Session) -> list[StoredModel]:
    """Return all models, oldest first."""
    rows = session.scalars(select(ModelTable).order_by(ModelTable.id)).all()
    return [_stored(session, row) for row in rows]


def now() -> dt.datetime:
    """Return the time in UTC, without a zone: not every database keeps one."""
    return dt.datetime.now(dt.UTC).replace(tzinfo=None)


def _stored(session: Session, row: ModelTable) -> StoredModel:
    made = row.name, row.specification, row.parent, row.effect_file, row.effect_sha256, row.created
    query = select(CalibrationTable).where(CalibrationTable.model == row.name)
    found = session.scalar(query.order_by(CalibrationTable.id.desc()).limit(1))
    if found is None:
        return StoredModel(*made)
    return StoredModel(*made, found.id, found.settings, found.result)


def document_checksum(model: str, document: Any) -> str:
    """SHA-256 of a result by `model`, the same before it is stored and after it is read."""
    # Keys become texts in the database.
    text = _sorted(json.loads(json.dumps(document)))
    return hashlib.sha256(f"{model}\n{text}".encode()).hexdigest()


def path_checksum(
    run: int, position: int, path_id: str, result: Any, notes: Any, failed: str | None
) -> str:
    """SHA-256 of what was found on one path of a run of `hazard` or `zones`; all keys are texts."""
    text = _sorted([run, position, path_id, result, notes, failed])
    return hashlib.sha256(text.encode()).hexdigest()


def _sorted(document: Any) -> str:
    # The order of keys in the database is nobody's business.
    return json.dumps(document, sort_keys=True, ensure_ascii=False)


def chunk_checksum(
    calibration: int, parameter: str, chunk: int, shape: tuple[int, int], data: bytes
) -> str:
    """SHA-256 of a chunk of draws of `shape` (chains, draws) and of the place where it belongs."""
    place = f"{calibration}\n{parameter}\n{chunk}\n{shape[0]} {shape[1]}\n".encode()
    return hashlib.sha256(place + data).hexdigest()


Draws = dict[str, NDArray[np.float64]]

CHUNK_NUMBERS = 8000  # 64 kB: what every database takes in one value
LITTLE_ENDIAN = np.dtype("<f8")


def save_draws(
    session: Session, calibration: int, draws: Mapping[str, NDArray[np.float64]]
) -> None:
    """Store the draws of every parameter, `[n_chains, n_draws]` each, under `calibration`."""
    rows = []
    for parameter, values in draws.items():
        array = np.ascontiguousarray(values, dtype=LITTLE_ENDIAN)
        if array.ndim != 2:
            raise ValueError(f"draws of {parameter} have shape {array.shape}, not two axes")
        n_chains, n_draws = array.shape
        step = max(1, CHUNK_NUMBERS // max(1, n_chains))
        for chunk, start in enumerate(range(0, n_draws, step)):
            piece = np.ascontiguousarray(array[:, start : start + step])
            rows.append(
                {
                    "calibration": calibration,
                    "parameter": parameter,
                    "chunk": chunk,
                    "n_chains": n_chains,
                    "n_draws": piece.shape[1],
                    "data": (data := piece.tobytes()),
                    "sha256": chunk_checksum(calibration, parameter, chunk, piece.shape, data),
                }
            )
    if rows:
        session.execute(insert(DrawChunkTable), rows)


def load_draws(session: Session, calibration: int) -> Draws:
    """Return the draws of every parameter, `[n_chains, n_draws]` each.

    Raises:
        AvahazardError: a chunk is missing or damaged.
    """
    pieces: dict[str, list[NDArray[np.float64]]] = {}
    query = (
        select(DrawChunkTable)
        .where(DrawChunkTable.calibration == calibration)
        .order_by(DrawChunkTable.parameter, DrawChunkTable.chunk)
    )
    for row in session.scalars(query):
        found = pieces.setdefault(row.parameter, [])
        fault = chunk_fault(row, len(found))
        if fault:
            raise AvahazardError(
                f"The draws of calibration {calibration} are damaged: {fault}.",
                "Look at the database with `avahazard db check`, or take a backup.",
            )
        array = np.frombuffer(row.data, dtype=LITTLE_ENDIAN).reshape(row.n_chains, row.n_draws)
        found.append(array)
    return {
        name: np.concatenate(arrays, axis=1).astype(np.float64) for name, arrays in pieces.items()
    }


def chunk_fault(row: DrawChunkTable, expected: int) -> str | None:
    """Return what is wrong with a chunk that should have the number `expected`."""
    if row.chunk != expected:
        return f"chunk {expected} of {row.parameter} is missing"
    if len(row.data) != row.n_chains * row.n_draws * LITTLE_ENDIAN.itemsize:
        return f"chunk {row.chunk} of {row.parameter} has {len(row.data)} bytes"
    shape = row.n_chains, row.n_draws
    if chunk_checksum(row.calibration, row.parameter, row.chunk, shape, row.data) != row.sha256:
        return f"chunk {row.chunk} of {row.parameter} is not what was stored (its checksum differs)"
    return None


def save_calibration(
    session: Session,
    model: str,
    *,
    settings: dict[str, Any],
    seed: int,
    data_fingerprint: str,
    diagnostics: dict[str, Any],
    converged: bool,
    result: dict[str, Any],
    draws: Mapping[str, NDArray[np.float64]],
) -> int:
    """Store a calibration of a stored model, with draws `[n_chains, n_draws]`; return its id.

    Raises:
        AvahazardError: there is no such model.
    """
    load_model(session, model)
    row = CalibrationTable(
        model=model,
        settings=plain(settings),
        seed=seed,
        data_fingerprint=data_fingerprint,
        diagnostics=plain(diagnostics),
        converged=bool(converged),
        result=plain(result),
        created=now(),
        sha256=document_checksum(model, plain(result)),
    )
    session.add(row)
    session.flush()
    save_draws(session, row.id, draws)
    return row.id


Kind = type[ResultTable]
COMPARISON: Kind = ComparisonTable
DIAGNOSIS: Kind = DiagnosisTable

RunKind = Literal["hazard", "zones"]
BOUNDS: RunKind = "hazard"
ZONES: RunKind = "zones"
READ_AHEAD = 50
"""Paths that are read at a time."""


@dataclass(frozen=True, slots=True)
class PathResult:
    """The documents of one path, plain, the `position`-th of its run; or why it `failed`.

    `hint`, what would mend that, is not stored.
    """

    position: int
    path_id: str
    documents: tuple[dict[str, Any], ...] = ()
    notes: tuple[str, ...] = ()
    failed: str | None = None
    hint: str = ""


def begin_run(
    session: Session, kind: RunKind, model: str, key: str, settings: Mapping[str, Any]
) -> tuple[int, set[str]]:
    """Begin a run, or take up the interrupted one of this key; with the paths that it has.

    Raises `AvahazardError` where there is no such model.
    """
    load_model(session, model)
    there = interrupted_run(session, kind, model, key)
    if there is not None:
        return there
    row = PathRunTable(kind=kind, model=model, key=key, settings=plain(settings), created=now())
    session.add(row)
    session.flush()
    return row.id, set()


def interrupted_run(
    session: Session, kind: RunKind, model: str, key: str
) -> tuple[int, set[str]] | None:
    """The run of this key that was not finished, with the paths that it has; None without one."""
    query = select(PathRunTable.id).where(
        PathRunTable.kind == kind,
        PathRunTable.model == model,
        PathRunTable.key == key,
        PathRunTable.finished.is_(None),
    )
    run = session.scalar(query.order_by(PathRunTable.id.desc()).limit(1))
    return None if run is None else (run, _paths(session, run))


def save_paths(session: Session, run: int, results: Sequence[PathResult]) -> None:
    """Store results of a run. Paths that it has stay: who computes them again gets the same."""
    # By the key of the table: their names stand among documents, which would all be read.
    kept = select(PathResultTable.position).where(
        PathResultTable.run == run,
        PathResultTable.position.in_([found.position for found in results]),
    )
    there = set(session.scalars(kept))
    for found in results:
        if found.position not in there:
            place = (run, found.position, found.path_id)
            told = (list(found.documents), list(found.notes), found.failed)
            session.add(
                PathResultTable(
                    run=run,
                    position=found.position,
                    path_id=found.path_id,
                    result=told[0],
                    notes=told[1],
                    failed=told[2],
                    sha256=path_checksum(*place, *told),
                )
            )
    session.flush()


def finish_run(session: Session, run: int) -> None:
    """Say that all paths of a run are there: from now on it is the latest."""
    session.get_one(PathRunTable, run).finished = now()
    session.flush()


def any_found(session: Session, run: int) -> bool:
    """Whether a run has a path that did not fail."""
    query = select(PathResultTable.position).where(
        PathResultTable.run == run, PathResultTable.failed.is_(None)
    )
    return session.scalar(query.limit(1)) is not None


def drop_run(session: Session, run: int) -> None:
    """Forget a run."""
    session.delete(session.get_one(PathRunTable, run))
    session.flush()


def read_run(session: Session, run: int) -> Iterator[PathResult]:
    """What a run found, in the order of its paths, a few in memory at a time."""
    table = PathResultTable
    query = select(table.position, table.path_id, table.result, table.notes, table.failed)
    ordered = query.where(table.run == run).order_by(table.position)
    for position, path_id, result, notes, failed in session.execute(
        ordered.execution_options(yield_per=READ_AHEAD)
    ):
        yield PathResult(position, path_id, tuple(result), tuple(notes), failed)


def latest_run(session: Session, kind: RunKind, model: str) -> int | None:
    """The last run that was finished, None where there is none."""
    query = select(PathRunTable.id).where(
        PathRunTable.kind == kind, PathRunTable.model == model, PathRunTable.finished.is_not(None)
    )
    return session.scalar(
        query.order_by(PathRunTable.finished.desc(), PathRunTable.id.desc()).limit(1)
    )


def latest_key(session: Session, kind: RunKind, model: str) -> str | None:
    """The key of all that the latest run hangs on, None without a run."""
    run = latest_run(session, kind, model)
    return None if run is None else session.get_one(PathRunTable, run).key


def latest_documents(session: Session, kind: RunKind, model: str) -> list[dict[str, Any]] | None:
    """All documents of the latest run, without the paths that failed; None without a run."""
    run = latest_run(session, kind, model)
    if run is None:
        return None
    return [document for found in read_run(session, run) for document in found.documents]


def _paths(session: Session, run: int) -> set[str]:
    return set(session.scalars(select(PathResultTable.path_id).where(PathResultTable.run == run)))


def save_result(session: Session, kind: Kind, model: str, document: dict[str, Any]) -> None:
    """Store what was found by `model`.

    Raises:
        AvahazardError: there is no such model.
    """
    load_model(session, model)
    result = plain(document)
    digest = document_checksum(model, result)
    session.add(kind(model=model, result=result, created=now(), sha256=digest))
    session.flush()


def latest_result(session: Session, kind: Kind, model: str) -> dict[str, Any] | None:
    """Return what was found last by `model`, None where nothing was."""
    query = select(kind.result).where(kind.model == model)
    return session.scalar(query.order_by(kind.id.desc()).limit(1))
