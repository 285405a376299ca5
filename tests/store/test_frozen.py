"""A database that nobody can write to is read all the same; a full disk is called so."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy import text
from sqlalchemy.exc import OperationalError

from avahazard.records.errors import AvahazardError
from avahazard.store import engine
from avahazard.store.session import reading, translated, writing


@pytest.fixture
def frozen(database: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """Give a database in a folder that may not be written to."""
    with closing(sqlite3.connect(database)) as connection:
        connection.execute("INSERT INTO paths (path_id) VALUES ('P')")
        connection.commit()
        connection.execute("PRAGMA journal_mode = WAL")
    monkeypatch.setattr(engine, "can_write", lambda _: False)  # root may write anywhere
    return database


def test_a_frozen_database_is_read_and_leaves_no_file(frozen: str) -> None:
    before = sorted(Path(frozen).parent.iterdir())
    with reading(frozen) as session:
        assert session.scalar(text("SELECT path_id FROM paths")) == "P"
    assert sorted(Path(frozen).parent.iterdir()) == before


def test_writing_to_a_frozen_database_says_what_to_look_at(frozen: str) -> None:
    with pytest.raises(AvahazardError, match="readonly") as caught, writing(frozen) as session:
        session.execute(text("DELETE FROM paths"))
    assert "permissions" in caught.value.hint


def test_a_full_disk_is_called_so(database: str) -> None:
    def fill() -> None:
        with writing(database) as session:
            pages = session.scalar(text("PRAGMA page_count"))
            session.execute(text(f"PRAGMA max_page_count = {pages}"))
            insert = text("INSERT INTO paths (path_id) VALUES (:p)")
            session.execute(insert, [{"p": f"{k:0200d}"} for k in range(2000)])

    with pytest.raises(AvahazardError) as caught:
        fill()
    assert "disk is full" in caught.value.message
    assert "Make room" in caught.value.hint
    with reading(database) as session:
        assert session.scalar(text("SELECT count(*) FROM paths")) == 0


def test_every_commit_is_synced(database: str) -> None:
    with writing(database) as session:
        assert session.scalar(text("PRAGMA synchronous")) == 2


def test_a_full_disk_of_a_server_is_called_so() -> None:
    reason = Exception("could not extend file: No space left on device")
    with pytest.raises(AvahazardError) as caught, translated("postgresql+psycopg://h/x"):
        raise OperationalError("INSERT", {}, reason)
    assert "disk is full" in caught.value.hint
