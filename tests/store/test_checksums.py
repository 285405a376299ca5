"""Pages that were swapped, zeroed or edited are found; old databases get their checksums."""

from __future__ import annotations

import numpy as np
import pytest
from alembic import command
from sqlalchemy import text

from avahazard.records.errors import AvahazardError
from avahazard.store import schema, upkeep
from avahazard.store.calibrations import save_calibration
from avahazard.store.check import check_database
from avahazard.store.draws import load_draws
from avahazard.store.engine import make_engine
from avahazard.store.models import save_model
from avahazard.store.path_results import BOUNDS
from avahazard.store.results import KINDS, save_result
from avahazard.store.session import reading, writing
from tests.store.documents import save_documents

DRAWS = {
    "a": np.linspace(0.4, 0.6, 8000).reshape(2, 4000),
    "ä µ": np.linspace(1.0, 2.0, 8000).reshape(2, 4000),
}
DOCUMENT = {"b": [1.0, 0.1, None, 1e-300], "a": {"ü": True, "2": 3}}


def calibrated(database: str, draws: dict[str, np.ndarray]) -> int:
    """Store the model `m` with draws; returns the key of its calibration."""
    with writing(database) as session:
        save_model(session, "m", {"paths": []})
        return save_calibration(
            session,
            "m",
            settings={},
            seed=1,
            data_fingerprint="f",
            diagnostics={},
            converged=True,
            result=DOCUMENT,
            draws=draws,
        )


def filled(database: str) -> None:
    """Store a model with draws, and a result of each kind."""
    calibrated(database, DRAWS)
    with writing(database) as session:
        for kind in KINDS:
            save_result(session, kind, "m", DOCUMENT)
        save_documents(session, BOUNDS, "m", [{"path_id": "P1", **DOCUMENT}])


def change(database: str, statement: str) -> None:
    engine = make_engine(database)
    with engine.begin() as connection:
        connection.execute(text(statement))
    engine.dispose()


def problems(database: str) -> list[str]:
    with reading(database) as session:
        return check_database(session)


def test_what_is_stored_has_its_checksum(any_database: str) -> None:
    filled(any_database)
    assert problems(any_database) == []


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE draw_chunks SET data = (SELECT data FROM draw_chunks WHERE parameter = 'a' "
        "AND chunk = 0) WHERE parameter = 'a' AND chunk = 1",
        "UPDATE draw_chunks SET chunk = 1 - chunk + 9 WHERE parameter = 'a'",
    ],
)
def test_swapped_chunks_are_found_and_not_used(any_database: str, statement: str) -> None:
    long = {"a": np.linspace(0.0, 1.0, 16000).reshape(2, 8000)}
    key = calibrated(any_database, long)
    change(any_database, statement)
    if "9" in statement:
        change(any_database, "UPDATE draw_chunks SET chunk = chunk - 9")
    assert any("checksum" in problem for problem in problems(any_database))
    with reading(any_database) as session, pytest.raises(AvahazardError, match="checksum"):
        load_draws(session, key)


def test_a_zeroed_page_of_draws_is_found(database: str) -> None:
    filled(database)
    change(database, "UPDATE draw_chunks SET data = zeroblob(length(data)) WHERE parameter = 'a'")
    (problem,) = problems(database)
    assert "draws of m" in problem
    assert "chunk 0 of a is not what was stored" in problem


@pytest.mark.parametrize("table", [kind.table.__tablename__ for kind in KINDS])
def test_an_edited_result_is_found(any_database: str, table: str) -> None:
    filled(any_database)
    change(any_database, f"""UPDATE {table} SET result = '{{"b": [2.0]}}'""")
    (problem,) = problems(any_database)
    assert f"Row 1 of {table}, by m, is not what was stored" in problem


@pytest.mark.parametrize("change_to", ["result = '[]'", "path_id = 'P2'", "notes = '[\"a\"]'"])
def test_an_edited_result_of_a_path_is_found(any_database: str, change_to: str) -> None:
    filled(any_database)
    change(any_database, f"UPDATE path_results SET {change_to}")
    (problem,) = problems(any_database)
    assert "path_results is not what was stored" in problem


def test_an_old_database_gets_its_checksums(any_database: str) -> None:
    filled(any_database)
    engine = make_engine(any_database, migrates=True).execution_options(writes=True)
    with engine.begin() as connection:
        config = schema._config()
        config.attributes["connection"] = connection
        command.downgrade(config, "0005")
    engine.dispose()
    assert upkeep.upgrade(any_database) == "old"
    assert problems(any_database) == []
    with reading(any_database) as session:
        draws = load_draws(session, 1)
        assert session.scalar(text("SELECT count(*) FROM path_results")) == 1
    for name, values in DRAWS.items():
        np.testing.assert_array_equal(draws[name], values)
    change(any_database, "UPDATE path_results SET result = '[]'")
    assert len(problems(any_database)) == 1
