"""Calibrations and their draws, comparisons, diagnoses, and what was found on each path."""

import datetime as dt
import hashlib
import re
import shlex
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, count
from typing import Any, Literal

import numpy as np
from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from avahazard.arrays import Floats
from avahazard.records.errors import AvahazardError, did_you_mean
from avahazard.results.base import plain
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

MADE = ("specification", "parent", "effect_file", "effect_sha256", "created")
"""Columns of a model that say how it was made."""
CHUNK_NUMBERS = 8000  # 64 kB: what every database takes in one value
LITTLE_ENDIAN = np.dtype("<f8")


@dataclass(frozen=True, slots=True)
class StoredModel:
    """A model by name, with its calibration but for the draws, which `calibration` finds.

    `effect_file` is the text of a user's own effects, for the record only; `result` is the document
    of the calibration, and `settings` are those of the sampler.
    """

    name: str
    specification: dict[str, Any]
    parent: str | None
    effect_file: str | None
    effect_sha256: str | None
    created: dt.datetime
    calibration: int
    settings: dict[str, Any]
    result: dict[str, Any]

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
    specification: dict[str, Any],
    settings: dict[str, Any],
    result: dict[str, Any],
    draws: Mapping[str, Floats],
    effect_file: str | None = None,
) -> None:
    """Store a new model with its calibration, and draws `[n_chains, n_draws]` of every parameter.

    `result` is the document of the calibration, which holds the names of the model and its parent;
    `settings` are those of the sampler. Raises `AvahazardError` where the name is taken, or the
    parent is not there.
    """
    document = plain(result)
    name, parent = document["model"], document["parent"]
    refuse_taken_name(session, name)
    if parent is not None:
        load_model(session, parent)
    digest = None if effect_file is None else hashlib.sha256(effect_file.encode()).hexdigest()
    made = plain(specification), parent, effect_file, digest, now()
    session.add(ModelTable(name=name, **dict(zip(MADE, made, strict=True))))
    session.flush()
    shown = {key: document[key] for key in ("seed", "data_fingerprint", "diagnostics")}
    row = CalibrationTable(model=name, settings=plain(settings), result=document, **shown)
    row.converged, row.created = document["diagnostics"]["converged"], now()
    session.add(row)
    session.flush()
    for parameter, values in draws.items():
        array = np.asarray(values, dtype=LITTLE_ENDIAN)
        step = max(1, CHUNK_NUMBERS // max(1, len(array)))
        for chunk, start in enumerate(range(0, array.shape[1], step)):
            piece = array[:, start : start + step]
            stored = DrawChunkTable(calibration=row.id, parameter=parameter, chunk=chunk)
            stored.n_chains, stored.n_draws = piece.shape
            stored.data = piece.tobytes()
            session.add(stored)


def refuse_taken_name(session: Session, name: str) -> None:
    """Refuse the name of a stored model, which is kept, and one that no file can have."""
    if not re.fullmatch(r"(?![-\s])[^/\\]{1,200}(?<!\s)", name) or not name.isprintable():
        raise AvahazardError(
            f"{name!r} cannot be the name of a model.",
            "Take 1 to 200 printable characters without / and \\, no hyphen first, no blank first "
            "or last.",
        )
    if session.scalar(select(ModelTable.id).where(ModelTable.name == name)) is not None:
        raise AvahazardError(
            f"There is a model {name} already.",
            "Take another name: a stored model is kept. `avahazard models` lists them.",
        )


def free_name(name: str, taken: Collection[str]) -> str:
    """The name, or the first of NAME-2, NAME-3 … that is not taken."""
    numbered = (f"{name}-{k}" for k in count(2))
    return next(one for one in chain((name,), numbered) if one not in taken)


def load_model(session: Session, name: str) -> StoredModel:
    """Return the model `name`. Raises `AvahazardError` where there is none."""
    row = session.scalar(select(ModelTable).where(ModelTable.name == name))
    if row is None:
        names = session.scalars(select(ModelTable.name).order_by(ModelTable.id)).all()
        hint = f"Make it: `avahazard calibrate {shlex.quote(name)}`."
        if names:
            hint = f"{did_you_mean(name, names)}Stored are: {', '.join(names)}."
        raise AvahazardError(f"There is no model {name}.", hint)
    return _stored(session, row)


def list_models(session: Session) -> list[StoredModel]:
    """Return all models, oldest first."""
    rows = session.scalars(select(ModelTable).order_by(ModelTable.id)).all()
    return [_stored(session, row) for row in rows]


def now() -> dt.datetime:
    """Return the time in UTC, without a zone: not every database keeps one."""
    return dt.datetime.now(dt.UTC).replace(tzinfo=None)


def _stored(session: Session, row: ModelTable) -> StoredModel:
    made: dict[str, Any] = {name: getattr(row, name) for name in ("name", *MADE)}
    query = select(CalibrationTable).where(CalibrationTable.model == row.name)
    found = session.scalars(query.order_by(CalibrationTable.id.desc()).limit(1)).one()
    return StoredModel(**made, calibration=found.id, settings=found.settings, result=found.result)


Draws = dict[str, Floats]


def load_draws(session: Session, calibration: int) -> Draws:
    """Return the draws `[n_chains, n_draws]` of every parameter; refused where damaged."""
    draws, faults = read_draws(session, calibration)
    if faults:
        raise AvahazardError(
            f"The draws of calibration {calibration} are damaged: {faults[0]}.",
            "Look at the database with `avahazard db check`, or take a backup.",
        )
    return draws


def read_draws(session: Session, calibration: int) -> tuple[Draws, list[str]]:
    """The draws of a calibration, and what is wrong with them; no draws where anything is."""
    pieces: dict[str, list[Floats]] = {}
    ends: dict[str, int] = {}
    sizes: dict[str, tuple[int, int]] = {}
    faults = []
    of_one = select(DrawChunkTable).where(DrawChunkTable.calibration == calibration)
    for row in session.scalars(of_one.order_by(DrawChunkTable.parameter, DrawChunkTable.chunk)):
        name, end = row.parameter, ends.get(row.parameter, 0)
        if row.chunk != end:
            faults.append(f"chunk {end} of {name} is missing")
        ends[name] = row.chunk + 1
        sizes[name] = row.n_chains, sizes.get(name, (0, 0))[1] + row.n_draws
        if len(row.data) != row.n_chains * row.n_draws * LITTLE_ENDIAN.itemsize:
            faults.append(f"chunk {row.chunk} of {name} has {len(row.data)} bytes")
        elif row.digest() != row.sha256:
            differs = "is not what was stored (its checksum differs)"
            faults.append(f"chunk {row.chunk} of {name} {differs}")
        else:
            numbers = np.frombuffer(row.data, LITTLE_ENDIAN).astype(np.float64)
            pieces.setdefault(name, []).append(numbers.reshape(row.n_chains, row.n_draws))
        session.expunge(row)
    if not sizes:
        faults.append("there are none")
    elif len(set(sizes.values())) > 1:
        told = ", ".join(f"{name} {c} × {n}" for name, (c, n) in sizes.items())
        faults.append(f"the parameters differ in number of chains or draws ({told})")
    joined = () if faults else pieces.items()
    return {name: np.concatenate(arrays, axis=1) for name, arrays in joined}, faults


Kind = type[ResultTable]
COMPARISON: Kind = ComparisonTable
DIAGNOSIS: Kind = DiagnosisTable

RunKind = Literal["hazard", "zones", "average"]
BOUNDS: RunKind = "hazard"
ZONES: RunKind = "zones"
AVERAGE: RunKind = "average"
"""Of several models; kept with the first."""
READ_AHEAD = 50
"""Paths that are read at a time."""


@dataclass(frozen=True, slots=True)
class PathResult:
    """The documents of the `position`-th path of a run, or why it `failed`; no `hint` is stored."""

    position: int
    path_id: str
    documents: tuple[dict[str, Any], ...] = ()
    notes: tuple[str, ...] = ()
    failed: str | None = None
    hint: str = ""


def begin_run(
    session: Session, kind: RunKind, model: str, key: str, settings: Mapping[str, Any]
) -> tuple[int, set[str]]:
    """Begin a run, or take up the interrupted one of this key; with the paths that it has."""
    load_model(session, model)
    unfinished = PathRunTable.key == key, PathRunTable.finished.is_(None)
    there = session.scalar(_runs(kind, model).where(*unfinished))
    if there is not None:
        paths = select(PathResultTable.path_id).where(PathResultTable.run == there.id)
        return there.id, set(session.scalars(paths))
    row = PathRunTable(kind=kind, model=model, key=key, settings=plain(settings), created=now())
    session.add(row)
    session.flush()
    return row.id, set()


def _runs(kind: RunKind, model: str) -> Select[PathRunTable]:
    """Runs of one kind by a model, the latest first."""
    query = select(PathRunTable).where(PathRunTable.kind == kind, PathRunTable.model == model)
    return query.order_by(PathRunTable.finished.desc(), PathRunTable.id.desc()).limit(1)


def save_paths(session: Session, run: int, results: Sequence[PathResult]) -> None:
    """Store results of a run. Paths that it has stay: who computes them again gets the same."""
    # By the key of the table: their names stand among documents, which would all be read.
    table, positions = PathResultTable, [found.position for found in results]
    kept = select(table.position).where(table.run == run, table.position.in_(positions))
    there = set(session.scalars(kept))
    for found in results:
        if found.position not in there:
            row = table(run=run, position=found.position, path_id=found.path_id)
            row.result, row.notes = list(found.documents), list(found.notes)
            row.failed = found.failed
            session.add(row)


def finish_run(session: Session, run: int) -> str | None:
    """Say that a run is complete; if all paths failed, forget it and return the first reason."""
    table = PathResultTable
    first = (table.failed.is_(None).desc(), table.position)
    found = session.scalar(select(table.failed).where(table.run == run).order_by(*first).limit(1))
    row = session.get_one(PathRunTable, run)
    if found is None:
        row.finished = now()
    else:
        session.delete(row)
    return found


def read_run(session: Session, run: int) -> Iterator[PathResult]:
    """What a run found, in the order of its paths, a few in memory at a time."""
    table = PathResultTable
    query = select(table.position, table.path_id, table.result, table.notes, table.failed)
    ordered = query.where(table.run == run).order_by(table.position)
    rows = session.execute(ordered.execution_options(yield_per=READ_AHEAD))
    for position, path_id, result, notes, failed in rows:
        yield PathResult(position, path_id, tuple(result), tuple(notes), failed)


def latest_run(session: Session, kind: RunKind, model: str) -> PathRunTable | None:
    """The last run that was finished, None where there is none."""
    return session.scalar(_runs(kind, model).where(PathRunTable.finished.is_not(None)))


def latest_documents(session: Session, kind: RunKind, model: str) -> list[dict[str, Any]] | None:
    """All documents of the latest run, without the paths that failed; None without a run."""
    run = latest_run(session, kind, model)
    if run is None:
        return None
    return [document for found in read_run(session, run.id) for document in found.documents]


def latest_by_path(session: Session, kind: RunKind, model: str) -> list[dict[str, Any]]:
    """Of every path the documents of the last run that it was in; none without a run."""
    finished = _runs(kind, model).where(PathRunTable.finished.is_not(None))
    found: dict[str, PathResult] = {}
    for run in session.scalars(finished.limit(None)):
        paths = select(PathResultTable.path_id).where(PathResultTable.run == run.id)
        if not found.keys() >= set(session.scalars(paths)):
            found = {one.path_id: one for one in read_run(session, run.id)} | found
    ordered = sorted(found.values(), key=lambda one: one.path_id)
    return [document for one in ordered for document in one.documents]


def save_result(session: Session, kind: Kind, model: str, document: dict[str, Any]) -> None:
    """Store what was found by `model`. Raises `AvahazardError` where there is no such model."""
    load_model(session, model)
    session.add(kind(model=model, result=plain(document), created=now()))


def latest_result(session: Session, kind: Kind, model: str) -> dict[str, Any] | None:
    """Return what was found last by `model`, None where nothing was."""
    query = select(kind.result).where(kind.model == model)
    return session.scalar(query.order_by(kind.id.desc()).limit(1))
