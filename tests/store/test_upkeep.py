"""Databases made and looked at."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from sqlalchemy import text

from avahazard.records.errors import AvahazardError
from avahazard.store import upkeep
from avahazard.store.engine import make_engine
from avahazard.store.session import reading


@pytest.fixture(params=["sqlite", "postgresql"])
def nothing(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Give a place for a database."""
    if request.param == "sqlite":
        return str(tmp_path / "new.db")
    return str(request.getfixturevalue("empty_postgresql"))


def test_create_makes_it_once(nothing: str) -> None:
    assert upkeep.create(nothing) == "empty"
    assert upkeep.create(nothing) == "current"
    status = upkeep.status(nothing)
    assert (status.state, status.revision) == ("current", status.head)
    assert status.counts == {"paths": 0, "events": 0, "speeds": 0, "models": 0, "calibrations": 0}


def test_a_database_of_another_program_is_left_alone(nothing: str) -> None:
    engine = make_engine(nothing, migrates=True)
    with engine.begin() as connection:
        connection.execute(text("CREATE TABLE other (x INTEGER)"))
    engine.dispose()
    assert upkeep.status(nothing).state == "foreign"
    for use in (upkeep.create, upkeep.upgrade):
        with pytest.raises(AvahazardError, match="other tables"):
            use(nothing)


def test_an_empty_database_has_to_be_created(tmp_path: Path) -> None:
    file = tmp_path / "empty.db"
    file.touch()
    with pytest.raises(AvahazardError) as caught, reading(str(file)):
        pass
    assert "avahazard init" in caught.value.hint
    with pytest.raises(AvahazardError, match="empty"):
        upkeep.upgrade(str(file))


def test_a_missing_file_is_not_made_by_looking(tmp_path: Path) -> None:
    file = tmp_path / "none.db"
    for use in (upkeep.status, upkeep.upgrade):
        with pytest.raises(AvahazardError) as caught:
            use(str(file))
        assert "avahazard init" in caught.value.hint
    assert not file.exists()


def test_a_missing_folder_and_a_folder_are_said(tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="no folder"):
        upkeep.create(str(tmp_path / "none" / "a.db"))
    with pytest.raises(AvahazardError, match="is a folder"):
        upkeep.create(str(tmp_path))


def test_sqlite_has_log_and_foreign_keys(database: str) -> None:
    with reading(database) as session:
        assert session.scalar(text("PRAGMA journal_mode")) == "wal"
        assert session.scalar(text("PRAGMA foreign_keys")) == 1
        assert session.scalar(text("PRAGMA busy_timeout")) == 600_000


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "notes.txt"
    file.write_text("These are notes, not a database. " * 50)
    with pytest.raises(AvahazardError, match="not a database"):
        upkeep.status(str(file))


def test_a_locked_database_says_so(database: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from avahazard.store import engine  # noqa: PLC0415
    from avahazard.store.session import writing  # noqa: PLC0415

    monkeypatch.setattr(engine, "BUSY_TIMEOUT_S", 0)
    other = sqlite3.connect(database, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    with pytest.raises(AvahazardError, match="locked"), writing(database) as session:
        session.execute(text("DELETE FROM events"))
    with reading(database) as session:  # a reader does not wait for a writer
        assert session.scalar(text("SELECT count(*) FROM events")) == 0
    other.close()
