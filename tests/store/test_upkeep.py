"""Databases made and looked at."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from sqlalchemy import Connection, text

from avahazard.records.collection import Path as AvalanchePath
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.store import upkeep
from avahazard.store.records import load_records, save_records
from avahazard.store.session import make_engine, reading, writing
from avahazard.store.upkeep import backup, check_database


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


def test_what_cannot_be_made_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(connection: Connection) -> None:
        connection.execute(text("CREATE TABLE half (x INTEGER)"))
        raise sqlite3.OperationalError("database or disk is full")

    file = tmp_path / "new.db"
    with monkeypatch.context() as patch:
        patch.setattr(upkeep.tables, "upgrade", full)
        with pytest.raises(sqlite3.OperationalError):
            upkeep.create(str(file))
        assert list(tmp_path.iterdir()) == []
        file.touch()
        with pytest.raises(sqlite3.OperationalError):
            upkeep.create(str(file))
        assert file.exists()
    assert upkeep.create(str(file)) == "empty"


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
    from avahazard.store import session as store_session  # noqa: PLC0415
    from avahazard.store.session import writing  # noqa: PLC0415

    monkeypatch.setattr(store_session, "BUSY_TIMEOUT_S", 0)
    other = sqlite3.connect(database, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    with pytest.raises(AvahazardError, match="locked"), writing(database) as session:
        session.execute(text("DELETE FROM events"))
    with reading(database) as session:  # a reader does not wait for a writer
        assert session.scalar(text("SELECT count(*) FROM events")) == 0
    other.close()


def test_a_copy_holds_what_was_stored_before_it(database: str, tmp_path: Path) -> None:
    copy = tmp_path / "copy.db"
    with writing(database) as session:
        save_records(session, Records((AvalanchePath("P"),)))
    with writing(database) as session:
        save_records(session, Records((AvalanchePath("Q"),)))
        session.flush()
        backup(database, copy)  # while another transaction is open
    assert not Path(f"{copy}-wal").exists()
    with reading(str(copy)) as session:
        assert [p.path_id for p in load_records(session).paths] == ["P"]


def test_nothing_is_overwritten(database: str, tmp_path: Path) -> None:
    copy = tmp_path / "copy.db"
    copy.write_text("mine")
    with pytest.raises(AvahazardError, match="there already"):
        backup(database, copy)
    assert copy.read_text() == "mine"


def test_a_copy_has_its_name_when_it_is_whole(
    database: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = tmp_path / "copy.db"
    whole = upkeep.written_whole

    @contextmanager
    def watched(file: Path) -> Iterator[Path]:
        with whole(file) as part:
            yield part
            assert not copy.exists()  # who kills it until now leaves nothing that looks like a copy
            with reading(str(part)) as session:
                assert load_records(session).paths == ()

    monkeypatch.setattr(upkeep, "written_whole", watched)
    backup(database, copy)
    assert copy.exists()
    assert [file.name for file in tmp_path.iterdir() if ".part" in file.name] == []


def test_a_missing_folder_is_told_by_the_name_that_was_asked_for(
    database: str, tmp_path: Path
) -> None:
    copy = tmp_path / "nowhere" / "copy.db"
    with pytest.raises(FileNotFoundError) as caught:
        backup(database, copy)
    assert caught.value.filename == str(copy)


def test_other_databases_have_their_own_tools(tmp_path: Path) -> None:
    with pytest.raises(AvahazardError) as caught:
        backup("postgresql://me:secret@host/x", tmp_path / "copy.db")
    assert "pg_dump" in caught.value.hint
    assert not (tmp_path / "copy.db").exists()


def test_a_damaged_database_leaves_no_copy(tmp_path: Path) -> None:
    file = tmp_path / "notes.txt"
    file.write_text("These are notes, not a database. " * 50)
    with pytest.raises(AvahazardError, match="not a database"):
        backup(str(file), tmp_path / "copy.db")
    assert not (tmp_path / "copy.db").exists()


def test_a_fresh_database_is_whole(any_database: str) -> None:
    with reading(any_database) as session:
        assert check_database(session) == []


def test_a_reference_to_nothing_is_found(database: str) -> None:
    connection = sqlite3.connect(database)
    connection.execute(
        "INSERT INTO speeds (event_id, x_m, speed_m_s, speed_sigma_m_s) VALUES ('z', 1, 2, 3)"
    )
    connection.commit()
    connection.close()
    with reading(database) as session:
        (problem,) = check_database(session)
    assert "speeds" in problem
    assert "events" in problem
