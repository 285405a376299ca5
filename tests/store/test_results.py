"""Comparisons, diagnoses, bounds and zones in every kind of database."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from alembic import command
from sqlalchemy import delete, func, select, text, update

from avahazard.records.errors import AvahazardError
from avahazard.store import tables, upkeep
from avahazard.store.results import (
    BOUNDS,
    COMPARISON,
    DIAGNOSIS,
    ZONES,
    Kind,
    PathResult,
    begin_run,
    finish_run,
    latest_by_path,
    latest_documents,
    latest_result,
    latest_run,
    list_models,
    load_draws,
    load_model,
    read_run,
    save_paths,
    save_result,
)
from avahazard.store.session import make_engine, reading, writing
from avahazard.store.tables import DrawChunkTable
from avahazard.store.upkeep import check_database
from tests.store.documents import save_bare, save_documents

SPECIFICATION = {"law": "exponential", "effects": ["turbulent-drag"], "depth": {"x": 1.5}}


def test_models_come_back_oldest_first(any_database: str) -> None:
    with writing(any_database) as session:
        save_bare(session, "b", SPECIFICATION)
        save_bare(session, "a", {}, parent="b", effect_file="x = 1\n")
    with reading(any_database) as session:
        first, second = list_models(session)
        assert load_model(session, "b") == first
    assert (first.name, first.specification, first.parent) == ("b", SPECIFICATION, None)
    assert (second.name, second.parent, second.effect_file) == ("a", "b", "x = 1\n")
    assert second.effect_sha256 == hashlib.sha256(b"x = 1\n").hexdigest()
    assert second.created >= first.created


def test_a_name_is_taken_once(any_database: str) -> None:
    with writing(any_database) as session:
        save_bare(session, "a", {})
    with pytest.raises(AvahazardError, match="a model a already"), writing(any_database) as session:
        save_bare(session, "a", SPECIFICATION)
    with reading(any_database) as session:
        assert load_model(session, "a").specification == {}


@pytest.mark.parametrize("name", ["", "  ", "x" * 201, "a\nb", "-x", "a/b", "a\\b"])
def test_a_name_can_be_that_of_a_file_and_an_argument(database: str, name: str) -> None:
    with pytest.raises(AvahazardError, match="1 to 200"), writing(database) as session:
        save_bare(session, name, {})


def test_a_missing_model_or_parent_is_said(database: str) -> None:
    with writing(database) as session:
        with pytest.raises(AvahazardError) as caught:
            load_model(session, "a")
        assert "avahazard calibrate a" in caught.value.hint
        save_bare(session, "b", {})
        with pytest.raises(AvahazardError, match="no model c") as caught:
            save_bare(session, "d", {}, parent="c")
        assert "Stored are: b" in caught.value.hint


def test_the_latest_results_come_back(any_database: str) -> None:
    with writing(any_database) as session:
        save_bare(session, "m", {})
        assert latest_result(session, COMPARISON, "m") is None
        assert latest_result(session, DIAGNOSIS, "m") is None
        assert latest_documents(session, BOUNDS, "m") is None
        assert latest_documents(session, ZONES, "m") is None
        for value in (1.0, 2.0):
            save_result(session, COMPARISON, "m", {"rmse_m": value, "bias_m": float("nan")})
            save_result(session, DIAGNOSIS, "m", {"detectable_m": value, "missing": []})
            save_documents(session, BOUNDS, "m", [{"path_id": "P", "mean": value}])
            save_documents(session, ZONES, "m", [{"path_id": "P", "beyond": value}])
    with reading(any_database) as session:
        assert latest_result(session, COMPARISON, "m") == {"rmse_m": 2.0, "bias_m": None}
        assert latest_result(session, DIAGNOSIS, "m") == {"detectable_m": 2.0, "missing": []}
        assert latest_documents(session, BOUNDS, "m") == [{"path_id": "P", "mean": 2.0}]
        assert latest_documents(session, ZONES, "m") == [{"path_id": "P", "beyond": 2.0}]


@pytest.mark.parametrize("kind", [COMPARISON, DIAGNOSIS, BOUNDS, ZONES])
def test_results_belong_to_a_model(kind: Kind, database: str) -> None:
    with writing(database) as session, pytest.raises(AvahazardError, match="no model"):
        save_result(session, kind, "m", {})


DRAWS = {
    "a": np.linspace(0.4, 0.6, 8000).reshape(2, 4000),
    "ä µ": np.linspace(1.0, 2.0, 8000).reshape(2, 4000),
}
HEAD: dict[str, Any] = {"seed": 1, "data_fingerprint": "f", "diagnostics": {"converged": True}}
DOCUMENT = {**HEAD, "b": [1.0, 0.1, None, 1e-300], "a": {"ü": True, "2": 3}}


def calibrated(database: str, draws: dict[str, np.ndarray]) -> int:
    """Store the model `m` with draws; returns the key of its calibration."""
    with writing(database) as session:
        save_bare(session, "m", result=DOCUMENT, draws=draws)
        return load_model(session, "m").calibration


def filled(database: str) -> None:
    """Store a model with draws, and a result of each kind."""
    calibrated(database, DRAWS)
    with writing(database) as session:
        for kind in (COMPARISON, DIAGNOSIS):
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


@pytest.mark.parametrize("table", ["comparisons", "diagnoses"])
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
        config = tables._config()
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


DRAWS_DRAWS = {"a": np.random.default_rng(1).normal(size=(4, 5001)), "b": np.zeros((4, 5001))}


@pytest.fixture
def calibration(any_database: str) -> tuple[str, int]:
    """Give a database with one calibration, and its id."""
    with writing(any_database) as session:
        save_bare(session, "m", result=HEAD, draws=DRAWS_DRAWS)
        return any_database, load_model(session, "m").calibration


def test_draws_come_back_in_chunks_of_64_kb(calibration: tuple[str, int]) -> None:
    database, id_ = calibration
    with reading(database) as session:
        found = load_draws(session, id_)
        assert session.scalar(select(func.count()).select_from(DrawChunkTable)) == 6
        assert max(len(data) for data in session.scalars(select(DrawChunkTable.data))) == 64000
        assert check_database(session) == []
    for name, values in DRAWS_DRAWS.items():
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


def test_a_model_comes_back_with_its_draws(any_database: str) -> None:
    draws = {"a": np.array([[0.1 + 0.2, 1.0]]), "sigma": np.array([[5e-324, -0.5]])}
    with writing(any_database) as session:
        document = {
            "seed": 2**62,
            "data_fingerprint": "f" * 64,
            "diagnostics": {"rhat_max": float("nan"), "converged": False},
            "parameters": {"a": {"mean": np.float64(0.5)}},
        }
        save_bare(session, "m", settings={"chains": np.int64(1)}, result=document, draws=draws)
    with reading(any_database) as session:
        found = load_model(session, "m")
        back = load_draws(session, found.calibration)
    assert (found.result["seed"], found.settings) == (2**62, {"chains": 1})
    assert found.result["parameters"]["a"]["mean"] == 0.5
    assert back.keys() == draws.keys()
    for name, values in draws.items():
        np.testing.assert_array_equal(back[name], values)


P = PathResult(0, "P", ({"path_id": "P", "x": 1.5},), ("far",))
Q = PathResult(1, "Q", failed="it is flat")
R = PathResult(2, "R", ({"path_id": "R", "x": 0.1 + 0.2},) * 2)


def test_a_run_comes_back_in_the_order_of_its_paths(any_database: str) -> None:
    with writing(any_database) as session:
        save_bare(session, "m", {})
        run, done = begin_run(session, BOUNDS, "m", "key", {"seed": 1})
        assert done == set()
        save_paths(session, run, [R, Q])
    with writing(any_database) as session:
        assert latest_run(session, BOUNDS, "m") is None
        others = [begin_run(session, BOUNDS, "m", "other", {})]
        others += [begin_run(session, ZONES, "m", "key", {})]
        assert all(other != run and done == set() for other, done in others)
        assert begin_run(session, BOUNDS, "m", "key", {"seed": 1}) == (run, {"Q", "R"})
        save_paths(session, run, [P, R])  # R once more: it stays
        finish_run(session, run)
    with reading(any_database) as session:
        assert list(read_run(session, run)) == [P, Q, R]
        latest = latest_run(session, BOUNDS, "m")
        assert latest is not None
        assert (latest.id, latest.key) == (run, "key")
        assert latest_documents(session, BOUNDS, "m") == [*P.documents, *R.documents]


def test_of_every_path_the_last_run_that_it_was_in_counts(any_database: str) -> None:
    later = replace(P, documents=({"path_id": "P", "x": 9.0},))
    with writing(any_database) as session:
        save_bare(session, "m", {})
        assert latest_by_path(session, BOUNDS, "m") == []
        for key, found in (("first", [P, R]), ("then", [later])):
            run, _ = begin_run(session, BOUNDS, "m", key, {})
            save_paths(session, run, found)
            finish_run(session, run)
    with reading(any_database) as session:
        assert latest_by_path(session, BOUNDS, "m") == [*later.documents, *R.documents]
        assert latest_documents(session, BOUNDS, "m") == [*later.documents]


def test_a_run_that_failed_on_all_paths_is_forgotten(any_database: str) -> None:
    with writing(any_database) as session:
        save_bare(session, "m", {})
        run, _ = begin_run(session, BOUNDS, "m", "key", {})
        save_paths(session, run, [replace(Q, position=0), Q])
        assert finish_run(session, run) == Q.failed
    with reading(any_database) as session:
        assert session.scalar(text("SELECT count(*) FROM path_results")) == 0
        assert latest_run(session, BOUNDS, "m") is None


def test_runs_belong_to_a_model(database: str) -> None:
    with writing(database) as session, pytest.raises(AvahazardError, match="no model"):
        begin_run(session, ZONES, "m", "key", {})


def test_results_of_an_older_program_are_kept(any_database: str) -> None:
    rows = [{"path_id": "P", "x": 1.0}, {"path_id": "P", "x": 2.0}, {"path_id": "R", "x": 3.0}]
    with writing(any_database) as session:
        save_bare(session, "m", {})
        save_documents(session, BOUNDS, "m", rows)
        save_documents(session, ZONES, "m", rows[2:])
    engine = make_engine(any_database, migrates=True)
    with engine.begin() as connection:
        config = tables._config()
        config.attributes["connection"] = connection
        command.downgrade(config, "0005")
    with engine.begin() as connection:
        found = connection.scalar(text("SELECT result FROM hazard_results"))
        assert (json.loads(found) if isinstance(found, str) else found) == rows
    engine.dispose()
    upkeep.upgrade(any_database)
    with reading(any_database) as session:
        assert latest_documents(session, BOUNDS, "m") == rows
        assert latest_documents(session, ZONES, "m") == rows[2:]
