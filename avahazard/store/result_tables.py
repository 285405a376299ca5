"""The tables of results: models, calibrations and their draws, comparisons, diagnoses, bounds."""

from __future__ import annotations

import datetime as dt
from typing import Any

from sqlalchemy import JSON, BigInteger, DateTime, ForeignKey, LargeBinary, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from avahazard.store.tables import Base, Name


class ModelTable(Base):
    """Models by name; a child names its parent. The effect file is kept as text, never run."""

    __tablename__ = "models"

    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(Name, unique=True)
    parent: Mapped[str | None] = mapped_column(Name, ForeignKey("models.name"))
    specification: Mapped[dict[str, Any]] = mapped_column(JSON)
    effect_file: Mapped[str | None] = mapped_column(Text)
    effect_sha256: Mapped[str | None] = mapped_column(String(64))
    created: Mapped[dt.datetime] = mapped_column(DateTime)


class ResultTable(Base):
    """What a command found by a model: the document that it prints, and its checksum."""

    __abstract__ = True

    id: Mapped[int] = mapped_column(primary_key=True)
    model: Mapped[str] = mapped_column(
        Name, ForeignKey("models.name", ondelete="CASCADE"), index=True
    )
    result: Mapped[Any] = mapped_column(JSON)
    created: Mapped[dt.datetime] = mapped_column(DateTime)
    sha256: Mapped[str] = mapped_column(String(64))


class CalibrationTable(ResultTable):
    """One run of a sampler, by `calibrate` or `add`."""

    __tablename__ = "calibrations"

    settings: Mapped[dict[str, Any]] = mapped_column(JSON)
    seed: Mapped[int] = mapped_column(BigInteger)
    data_fingerprint: Mapped[str] = mapped_column(String(64))
    diagnostics: Mapped[dict[str, Any]] = mapped_column(JSON)
    converged: Mapped[bool]


class DrawChunkTable(Base):
    """Draws `[n_chains, n_draws]` of one parameter, cut along the draws: little-endian float64."""

    __tablename__ = "draw_chunks"

    calibration: Mapped[int] = mapped_column(
        ForeignKey("calibrations.id", ondelete="CASCADE"), primary_key=True
    )
    parameter: Mapped[str] = mapped_column(Name, primary_key=True)
    chunk: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    n_chains: Mapped[int]
    n_draws: Mapped[int]
    data: Mapped[bytes] = mapped_column(LargeBinary)
    sha256: Mapped[str] = mapped_column(String(64))


class ComparisonTable(ResultTable):
    """Scores of a model against the measurements, by `compare`."""

    __tablename__ = "comparisons"


class DiagnosisTable(ResultTable):
    """Which effect a model lacks, by `diagnose`."""

    __tablename__ = "diagnoses"


class PathRunTable(Base):
    """One run of `hazard` or `zones` (`kind`) over paths; not `finished`: it was interrupted.

    `key` is that of all that the result hangs on, which `settings` tell.
    """

    __tablename__ = "path_runs"

    id: Mapped[int] = mapped_column(primary_key=True)
    kind: Mapped[str] = mapped_column(String(20))
    model: Mapped[str] = mapped_column(
        Name, ForeignKey("models.name", ondelete="CASCADE"), index=True
    )
    key: Mapped[str] = mapped_column(String(64))
    settings: Mapped[dict[str, Any]] = mapped_column(JSON)
    created: Mapped[dt.datetime] = mapped_column(DateTime)
    finished: Mapped[dt.datetime | None] = mapped_column(DateTime)


class PathResultTable(Base):
    """What was found on one path of a run, a list of documents, with notes; or why nothing was."""

    __tablename__ = "path_results"

    run: Mapped[int] = mapped_column(
        ForeignKey("path_runs.id", ondelete="CASCADE"), primary_key=True
    )
    position: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    path_id: Mapped[str] = mapped_column(Name)
    result: Mapped[list[Any]] = mapped_column(JSON)
    notes: Mapped[list[Any]] = mapped_column(JSON)
    failed: Mapped[str | None] = mapped_column(Text)
    sha256: Mapped[str] = mapped_column(String(64))
