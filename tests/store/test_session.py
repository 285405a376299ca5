"""Databases by path and by URL."""

from __future__ import annotations

import sqlite3
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from threading import Barrier, Timer

import pytest
from alembic import command
from sqlalchemy import text
from sqlalchemy.exc import OperationalError

from avahazard.records.errors import AvahazardError
from avahazard.store import session as store_session
from avahazard.store import tables, upkeep
from avahazard.store.session import (
    database_name,
    database_url,
    engine_of,
    make_engine,
    reading,
    writing,
)
from avahazard.workflow.calibrate import add, calibrate
from avahazard.workflow.database import upgrade_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest


def test_a_path_is_an_sqlite_file() -> None:
    url = database_url("folder/my file.db")
    assert (url.drivername, url.database) == ("sqlite", "folder/my file.db")
    assert database_name("sqlite:///a.db") == "a.db"


def test_passwords_are_not_shown() -> None:
    assert database_name("postgresql+psycopg://me:secret@host/x") == (
        "postgresql+psycopg://me:***@host/x"
    )


@pytest.mark.parametrize(
    ("database", "message"),
    [
        ("://me:secret@host", "not the URL"),
        ("nonsense://me:secret@host/x", "no driver for nonsense"),
        ("sqlite://", "has no file"),
        (":memory:", "has no file"),
    ],
)
def test_unusable_urls_are_said_without_their_password(database: str, message: str) -> None:
    with pytest.raises(AvahazardError, match=message) as caught:
        make_engine(database)
    assert "secret" not in caught.value.message


def test_a_server_that_does_not_answer_is_one_message() -> None:
    from avahazard.store.upkeep import status  # noqa: PLC0415

    with pytest.raises(AvahazardError, match="does not answer"):
        status("postgresql+psycopg://me:secret@127.0.0.1:1/x")


N_WRITERS, N_TURNS = 6, 5


def test_writers_that_change_one_row_all_succeed(any_database: str) -> None:
    with writing(any_database) as session:
        session.execute(text("INSERT INTO paths (path_id, observed_from) VALUES ('P', 0)"))
    start = Barrier(N_WRITERS)

    def write(_: int) -> None:
        start.wait()
        for _turn in range(N_TURNS):
            with writing(any_database) as session:
                n = session.scalar(text("SELECT observed_from FROM paths"))
                session.execute(text("UPDATE paths SET observed_from = :n"), {"n": n + 1})

    with ThreadPoolExecutor(N_WRITERS) as pool:
        list(pool.map(write, range(N_WRITERS)))
    with reading(any_database) as session:
        assert session.scalar(text("SELECT observed_from FROM paths")) == N_WRITERS * N_TURNS


def downgraded(database: str, revision: str) -> None:
    engine = make_engine(database, migrates=True).execution_options(writes=True)
    with engine.begin() as connection:
        config = tables._config()
        config.attributes["connection"] = connection
        command.downgrade(config, revision)
    engine.dispose()


def test_who_waits_for_another_program_says_so(
    database: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(store_session, "SILENT_S", 0.05)
    other = sqlite3.connect(database, isolation_level=None, check_same_thread=False)
    other.execute("BEGIN IMMEDIATE")
    release = Timer(0.5, other.rollback)
    release.start()
    with writing(database) as session:
        session.execute(text("SELECT 1"))
    release.join()
    other.close()
    assert "in use by another program: waiting" in capfd.readouterr().err


def test_two_upgrades_at_once_do_no_harm(any_database: str) -> None:
    with writing(any_database) as session:
        session.execute(text("INSERT INTO paths (path_id) VALUES ('P')"))
    downgraded(any_database, "0004")
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda _: upkeep.upgrade(any_database), range(2)))
    assert sorted(found) == ["current", "old"]
    with reading(any_database) as session:
        assert session.scalar(text("SELECT count(*) FROM paths")) == 1


def test_an_upgrade_copies_the_file_before(database: str) -> None:
    downgraded(database, "0005")
    found = upgrade_database(database)
    assert found.backup == f"{database}.before-{tables.head()}"
    assert upkeep.status(found.backup).revision == "0005"
    downgraded(database, "0005")
    assert upgrade_database(database).backup == f"{database}.before-{tables.head()}"
    assert upgrade_database(database).backup is None
    assert Path(found.backup).is_file()


@pytest.fixture
def frozen(database: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """Give a database in a folder that may not be written to."""
    with closing(sqlite3.connect(database)) as connection:
        connection.execute("INSERT INTO paths (path_id) VALUES ('P')")
        connection.commit()
        connection.execute("PRAGMA journal_mode = WAL")
    monkeypatch.setattr(store_session, "can_write", lambda _: False)  # root may write anywhere
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


def test_what_cannot_be_written_is_refused_before_the_work(frozen: str) -> None:
    for work in (
        lambda: calibrate(frozen, "first", CalibrateRequest()),
        lambda: add(frozen, "first", ["season"], "second"),
        lambda: diagnose_model(frozen, "first", DiagnoseRequest()),
    ):
        with pytest.raises(AvahazardError, match="cannot be written") as caught:
            work()
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
    with pytest.raises(AvahazardError) as caught, engine_of("postgresql+psycopg://h/x"):
        raise OperationalError("INSERT", {}, reason)
    assert "disk is full" in caught.value.hint
