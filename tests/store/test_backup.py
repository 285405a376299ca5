"""Copies of a database in use."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.path import Path as AvalanchePath
from avahazard.store.backup import backup
from avahazard.store.records import load_records
from avahazard.store.save_records import save_records
from avahazard.store.session import reading, writing


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
