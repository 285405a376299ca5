"""Draws of a sampler as chunked arrays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import insert, select
from sqlalchemy.orm import Session

from avahazard.records.errors import AvahazardError
from avahazard.store.checksums import chunk_checksum
from avahazard.store.result_tables import DrawChunkTable

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
