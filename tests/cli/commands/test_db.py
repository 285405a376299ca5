"""`avahazard db upgrade`, `status`, `check` and `backup`."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path

from typer.testing import Result

Run = Callable[..., Result]


def change(database: str, statement: str) -> None:
    """Change the file behind the program's back."""
    connection = sqlite3.connect(database)
    connection.execute(statement)
    connection.commit()
    connection.close()


def test_status(avahazard: Run) -> None:
    done = avahazard("--json", "db", "status")
    document = json.loads(done.stdout)
    assert document["state"] == "current"
    assert document["revision"] == document["head"]
    assert document["counts"]["paths"] == 0
    assert "current" in avahazard("db", "status").stdout


def test_upgrade_of_a_current_database_changes_nothing(avahazard: Run) -> None:
    document = json.loads(avahazard("--json", "db", "upgrade").stdout)
    assert document["from"] == document["to"]
    assert "is up to date" in avahazard("db", "upgrade").stdout


def test_a_newer_database_is_refused(avahazard: Run, database: str) -> None:
    change(database, "UPDATE alembic_version SET version_num = 'ffff'")
    for words in (("paths",), ("db", "upgrade"), ("db", "check")):
        done = avahazard(*words)
        assert (done.exit_code, done.stdout) == (1, "")
        assert "Update the program" in done.stderr


def test_check(avahazard: Run, database: str) -> None:
    assert json.loads(avahazard("--json", "db", "check").stdout)["whole"] is True
    assert "is whole" in avahazard("db", "check").stdout
    change(database, "INSERT INTO path_covariates VALUES ('z', 'n', 0, 1.0, NULL)")
    done = avahazard("--json", "db", "check")
    assert (done.exit_code, done.stdout) == (1, "")
    assert "not whole" in done.stderr
    assert "path_covariates" in done.stderr


def test_backup(avahazard: Run, tmp_path: Path) -> None:
    copy = tmp_path / "copy.db"
    assert avahazard("db", "backup", str(copy)).exit_code == 0
    assert sqlite3.connect(copy).execute("SELECT count(*) FROM paths").fetchone() == (0,)
    done = avahazard("db", "backup", str(copy))
    assert (done.exit_code, done.stdout) == (1, "")
    assert "there already" in done.stderr
