"""Draws as chunked arrays."""

from __future__ import annotations

import numpy as np
import pytest
from sqlalchemy import delete, func, select, update

from avahazard.records.errors import AvahazardError
from avahazard.store.calibrations import save_calibration
from avahazard.store.check import check_database
from avahazard.store.draws import load_draws, save_draws
from avahazard.store.models import save_model
from avahazard.store.result_tables import DrawChunkTable
from avahazard.store.session import reading, writing

DRAWS = {"a": np.random.default_rng(1).normal(size=(4, 5001)), "b": np.zeros((4, 5001))}


@pytest.fixture
def calibration(any_database: str) -> tuple[str, int]:
    """Give a database with one calibration, and its id."""
    with writing(any_database) as session:
        save_model(session, "m", {})
        id_ = save_calibration(
            session,
            "m",
            settings={},
            seed=0,
            data_fingerprint="",
            diagnostics={},
            converged=True,
            result={},
            draws=DRAWS,
        )
    return any_database, id_


def test_draws_come_back_in_chunks_of_64_kb(calibration: tuple[str, int]) -> None:
    database, id_ = calibration
    with reading(database) as session:
        found = load_draws(session, id_)
        assert session.scalar(select(func.count()).select_from(DrawChunkTable)) == 6
        assert max(len(data) for data in session.scalars(select(DrawChunkTable.data))) == 64000
        assert check_database(session) == []
    for name, values in DRAWS.items():
        np.testing.assert_array_equal(found[name], values)
        assert found[name].dtype == np.float64


def test_a_missing_chunk_is_found(calibration: tuple[str, int]) -> None:
    database, id_ = calibration
    with writing(database) as session:
        session.execute(
            delete(DrawChunkTable).where(DrawChunkTable.parameter == "a", DrawChunkTable.chunk == 1)
        )
    with reading(database) as session:
        with pytest.raises(AvahazardError, match="chunk 1 of a is missing"):
            load_draws(session, id_)
        problems = check_database(session)
    assert any("chunk 1 of a is missing" in p for p in problems)
    assert any("differ" in p for p in problems)


def test_a_short_chunk_is_found(calibration: tuple[str, int]) -> None:
    database, id_ = calibration
    with writing(database) as session:
        session.execute(
            update(DrawChunkTable)
            .where(DrawChunkTable.parameter == "b", DrawChunkTable.chunk == 0)
            .values(data=b"\0" * 8)
        )
    with reading(database) as session:
        with pytest.raises(AvahazardError, match="chunk 0 of b has 8 bytes"):
            load_draws(session, id_)
        assert any("chunk 0 of b has 8 bytes" in p for p in check_database(session))


def test_lost_draws_are_found(calibration: tuple[str, int]) -> None:
    database, _ = calibration
    with writing(database) as session:
        session.execute(delete(DrawChunkTable))
    with reading(database) as session:
        assert any("there are none" in p for p in check_database(session))


def test_draws_have_two_axes(database: str) -> None:
    with writing(database) as session, pytest.raises(ValueError, match="shape"):
        save_draws(session, 1, {"a": np.zeros(3)})
