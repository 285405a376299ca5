"""The ground around paths, in and out of the database."""

from __future__ import annotations

import numpy as np
import pytest
from sqlalchemy import update

from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.path import Path
from avahazard.records.terrain_crop import TerrainCrop
from avahazard.store.save_records import save_records
from avahazard.store.session import reading, writing
from avahazard.store.tables import TerrainTable
from avahazard.store.terrain import load_terrain, save_terrain


def crop(path_id: str, start: float) -> TerrainCrop:
    """Give a small piece of ground with a hole in it."""
    elevation = np.arange(6, dtype=np.float32).reshape(2, 3) + np.float32(start)
    elevation[1, 1] = np.nan
    return TerrainCrop(path_id, "EPSG:31287", 255_000.5, 382_000.25, 12.5, elevation)


def test_terrain_comes_back_and_is_replaced(any_database: str) -> None:
    with writing(any_database) as session:
        save_records(session, Records(paths=(Path("P"), Path("Q"), Path("R"))))
        save_terrain(session, [crop("P", 0.0), crop("Q", 1.0)])
    with writing(any_database) as session:
        save_terrain(session, [crop("P", 7.0)], outdated=["Q", "R"])
    with reading(any_database) as session:
        found = load_terrain(session, "P")
        assert (load_terrain(session, "Q"), load_terrain(session, "R")) == (None, None)
    assert found is not None
    expected = crop("P", 7.0)
    assert found.elevation_m.dtype == np.float32
    np.testing.assert_array_equal(found.elevation_m, expected.elevation_m)
    place = (found.crs, found.west_m, found.north_m, found.cell_m)
    assert place == (expected.crs, expected.west_m, expected.north_m, expected.cell_m)


def test_damaged_terrain_is_told(database: str) -> None:
    with writing(database) as session:
        save_records(session, Records(paths=(Path("P"),)))
        save_terrain(session, [crop("P", 0.0)])
        session.execute(update(TerrainTable).values(data=b"123"))
    with reading(database) as session, pytest.raises(AvahazardError, match="damaged"):
        load_terrain(session, "P")
