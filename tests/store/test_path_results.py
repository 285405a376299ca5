"""Results path by path: batches, what was interrupted, and those of an older program."""

from __future__ import annotations

import json

import pytest
from alembic import command
from sqlalchemy import text

from avahazard.records.errors import AvahazardError
from avahazard.store import schema, upkeep
from avahazard.store.engine import make_engine
from avahazard.store.models import save_model
from avahazard.store.path_results import (
    BOUNDS,
    ZONES,
    PathResult,
    begin_run,
    drop_run,
    finish_run,
    interrupted_run,
    latest_documents,
    latest_run,
    read_run,
    save_paths,
)
from avahazard.store.session import reading, writing
from tests.store.documents import save_documents

P = PathResult(0, "P", ({"path_id": "P", "x": 1.5},), ("far",))
Q = PathResult(1, "Q", failed="it is flat")
R = PathResult(2, "R", ({"path_id": "R", "x": 0.1 + 0.2},) * 2)


def test_a_run_comes_back_in_the_order_of_its_paths(any_database: str) -> None:
    with writing(any_database) as session:
        save_model(session, "m", {})
        run, done = begin_run(session, BOUNDS, "m", "key", {"seed": 1})
        assert done == set()
        save_paths(session, run, [R, Q])
    with writing(any_database) as session:
        assert latest_run(session, BOUNDS, "m") is None
        assert interrupted_run(session, BOUNDS, "m", "other") is None
        assert interrupted_run(session, ZONES, "m", "key") is None
        assert begin_run(session, BOUNDS, "m", "key", {"seed": 1}) == (run, {"Q", "R"})
        save_paths(session, run, [P, R])  # R once more: it stays
        finish_run(session, run)
    with reading(any_database) as session:
        assert list(read_run(session, run)) == [P, Q, R]
        assert latest_run(session, BOUNDS, "m") == run
        assert interrupted_run(session, BOUNDS, "m", "key") is None
        assert latest_documents(session, BOUNDS, "m") == [*P.documents, *R.documents]


def test_a_run_goes_with_its_paths(any_database: str) -> None:
    with writing(any_database) as session:
        save_model(session, "m", {})
        run, _ = begin_run(session, BOUNDS, "m", "key", {})
        save_paths(session, run, [P])
        drop_run(session, run)
    with reading(any_database) as session:
        assert session.scalar(text("SELECT count(*) FROM path_results")) == 0


def test_runs_belong_to_a_model(database: str) -> None:
    with writing(database) as session, pytest.raises(AvahazardError, match="no model"):
        begin_run(session, ZONES, "m", "key", {})


def test_results_of_an_older_program_are_kept(any_database: str) -> None:
    rows = [{"path_id": "P", "x": 1.0}, {"path_id": "P", "x": 2.0}, {"path_id": "R", "x": 3.0}]
    with writing(any_database) as session:
        save_model(session, "m", {})
        save_documents(session, BOUNDS, "m", rows)
        save_documents(session, ZONES, "m", rows[2:])
    engine = make_engine(any_database, migrates=True)
    with engine.begin() as connection:
        config = schema._config()
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
