"""Runs of flow models on the terrain of paths."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from typing import Any

import numpy as np
from sqlalchemy import delete, select
from sqlalchemy.orm import Session, defer

from avahazard.records.errors import AvahazardError
from avahazard.records.simulation import Simulation
from avahazard.store.tables import SimulationTable

LITTLE_ENDIAN = np.dtype("<f4")
Chosen = Callable[[Any], Any]
"""Makes the condition that a column of path names holds."""
PLAIN = ("path_id", "engine", "friction", "volume_m3", "drag_per_m", "ground", "left_profile")


def save_simulation(session: Session, run: Simulation) -> None:
    """Store a run, with its peak pressures, in the place of one made before on other ground."""
    assert run.peak_kpa is not None
    table = SimulationTable
    key = ("path_id", "engine", "friction", "volume_m3", "drag_per_m")
    same = [getattr(table, name) == getattr(run, name) for name in key]
    session.execute(delete(table).where(*same))
    n_rows, n_columns = run.peak_kpa.shape
    session.add(
        table(
            **{name: getattr(run, name) for name in PLAIN},
            stop_x_m=None if np.isnan(run.stop_x_m) else float(run.stop_x_m),
            seconds=run.seconds,
            n_rows=n_rows,
            n_columns=n_columns,
            data=zlib.compress(run.peak_kpa.astype(LITTLE_ENDIAN).tobytes()),
        )
    )


def load_simulations(
    session: Session, chosen: Chosen | None = None, *, peaks: bool = False
) -> list[Simulation]:
    """Return the runs on chosen paths, or all, by path, volume and friction; with `peaks`, theirs.

    Raises `AvahazardError` where what is stored of a peak field is damaged.
    """
    table = SimulationTable
    query = select(table).order_by(table.path_id, table.volume_m3, table.friction)
    if chosen is not None:
        query = query.where(chosen(table.path_id))
    if not peaks:
        query = query.options(defer(table.data))
    return [_read(row, peaks) for row in session.scalars(query)]


def _read(row: SimulationTable, peaks: bool) -> Simulation:
    peak = None
    if peaks:
        try:
            values = np.frombuffer(zlib.decompress(row.data), LITTLE_ENDIAN)
            peak = values.reshape(row.n_rows, row.n_columns).astype(np.float32)
        except (zlib.error, ValueError) as error:
            raise AvahazardError(
                f"A stored run of {row.engine} on path {row.path_id} is damaged.",
                "Take a backup, or a new database, and simulate again.",
            ) from error
    return Simulation(
        **{name: getattr(row, name) for name in PLAIN},
        stop_x_m=np.nan if row.stop_x_m is None else row.stop_x_m,
        seconds=row.seconds,
        peak_kpa=peak,
    )
