"""Copies of a database in use."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.path import Path as AvalanchePath
from avahazard.store import backup as store_backup
from avahazard.store.backup import backup, backup_beside
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


def test_a_copy_has_its_name_when_it_is_whole(
    database: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = tmp_path / "copy.db"
    put = store_backup.put_new_in_place

    def watched(part: Path, file: Path) -> None:
        assert not copy.exists()  # who kills it until now leaves nothing that looks like a copy
        with reading(str(part)) as session:
            assert load_records(session).paths == ()
        put(part, file)

    monkeypatch.setattr(store_backup, "put_new_in_place", watched)
    backup(database, copy)
    assert copy.exists()
    assert [file.name for file in tmp_path.iterdir() if ".part" in file.name] == []


def test_copies_beside_one_another_are_numbered(database: str, tmp_path: Path) -> None:
    name = str(tmp_path / "copy.db")
    assert [backup_beside(database, name) for _ in range(3)] == [name, f"{name}-2", f"{name}-3"]


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
