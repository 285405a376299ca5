"""The ground around paths, in and out of the database."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from sqlalchemy import delete, insert
from sqlalchemy.orm import Session

from avahazard.records.errors import AvahazardError
from avahazard.records.terrain_crop import TerrainCrop
from avahazard.store.tables import TerrainTable

LITTLE_ENDIAN = np.dtype("<f4")


def save_terrain(
    session: Session, crops: Sequence[TerrainCrop], outdated: Iterable[str] = ()
) -> None:
    """Store `crops`, in the place of those stored before for their paths and for `outdated`."""
    for path_id in sorted({*outdated, *(crop.path_id for crop in crops)}):
        session.execute(delete(TerrainTable).where(TerrainTable.path_id == path_id))
    for crop in crops:
        n_rows, n_columns = crop.elevation_m.shape
        values = {
            "path_id": crop.path_id,
            "crs": crop.crs,
            "west_m": crop.west_m,
            "north_m": crop.north_m,
            "cell_m": crop.cell_m,
            "n_rows": n_rows,
            "n_columns": n_columns,
            "data": np.ascontiguousarray(crop.elevation_m, LITTLE_ENDIAN).tobytes(),
        }
        session.execute(insert(TerrainTable), values)


def load_terrain(session: Session, path_id: str) -> TerrainCrop | None:
    """Return the ground around a path, None where no terrain model was given for it.

    Raises:
        AvahazardError: what is stored is damaged.
    """
    row = session.get(TerrainTable, path_id)
    if row is None:
        return None
    if len(row.data) != row.n_rows * row.n_columns * LITTLE_ENDIAN.itemsize:
        raise AvahazardError(
            f"The terrain stored for path {path_id} is damaged: it has {len(row.data)} bytes.",
            "Import the line of the path again with --dem and --update, or take a backup.",
        )
    values = np.frombuffer(row.data, LITTLE_ENDIAN).reshape(row.n_rows, row.n_columns)
    return TerrainCrop(
        path_id, row.crs, row.west_m, row.north_m, row.cell_m, values.astype(np.float32)
    )
