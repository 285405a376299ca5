"""`avahazard init`."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from avahazard.cli.main import app


def test_init_creates_the_default_database_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("AVAHAZARD_DB", raising=False)
    for word in ("was created", "exists"):
        done = CliRunner().invoke(app, ["init"])
        assert done.stdout == f"The database avahazard.db {word}.\n"
    assert (tmp_path / "avahazard.db").exists()


def test_init_as_json(tmp_path: Path) -> None:
    file = str(tmp_path / "a.db")
    done = CliRunner().invoke(app, ["--db", file, "--json", "init"])
    assert json.loads(done.stdout) == {"database": file, "created": True}


def test_init_leaves_other_files_alone(tmp_path: Path) -> None:
    other = tmp_path / "other.db"
    connection = sqlite3.connect(other)
    connection.execute("CREATE TABLE t (x)")
    connection.close()
    done = CliRunner().invoke(app, ["--db", str(other), "init"])
    assert (done.exit_code, done.stdout) == (1, "")
    assert "other tables" in done.stderr


def test_init_says_that_an_existing_database_is_newer(
    avahazard: Callable[..., Result], database: str
) -> None:
    connection = sqlite3.connect(database)
    connection.execute("UPDATE alembic_version SET version_num = 'ffff'")
    connection.commit()
    connection.close()
    done = avahazard("init")
    assert (done.exit_code, done.stdout) == (1, "")
    assert "Update the program" in done.stderr
