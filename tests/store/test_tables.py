"""Schema and migrations."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import text

from avahazard.records.errors import AvahazardError
from avahazard.store import tables, upkeep
from avahazard.store.session import make_engine, reading
from avahazard.store.tables import Base


def set_revision(database: str, revision: str) -> None:
    """Pretend that another version of the program made the database."""
    engine = make_engine(database)
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = :r"), {"r": revision})
    engine.dispose()


def add_old_revision(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """Put a further migration on top, so that a database of today is an old one."""
    migrations = folder / "migrations"
    shutil.copytree(Path(str(tables.files("avahazard.migrations"))), migrations)
    (migrations / "versions" / "later.py").write_text(
        "from alembic import op\nimport sqlalchemy as sa\n"
        f"revision = 'later'\ndown_revision = {tables.head()!r}\n"
        "def upgrade():\n"
        "    with op.batch_alter_table('paths') as batch:\n"
        "        batch.add_column(sa.Column('extra', sa.Text()))\n"
        "        batch.alter_column('name', new_column_name='title')\n"
    )
    monkeypatch.setattr(tables, "files", lambda _: migrations)


def test_migrations_make_the_tables_of_the_models(any_database: str) -> None:
    engine = make_engine(any_database)
    with engine.connect() as connection:
        context = MigrationContext.configure(
            connection, opts={"compare_type": True, "compare_server_default": True}
        )
        assert compare_metadata(context, Base.metadata) == []
    engine.dispose()


def test_a_current_database_opens(any_database: str) -> None:
    assert upkeep.status(any_database).state == "current"
    with reading(any_database) as session:
        assert session.scalar(text("SELECT count(*) FROM events")) == 0


def test_a_newer_database_is_refused(any_database: str) -> None:
    set_revision(any_database, "ffff")
    assert upkeep.status(any_database).state == "newer"
    with pytest.raises(AvahazardError) as caught, reading(any_database):
        pass
    assert "Update the program" in caught.value.hint
    with pytest.raises(AvahazardError, match="newer version"):
        upkeep.upgrade(any_database)


def test_an_old_database_is_refused_and_upgraded(
    any_database: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine = make_engine(any_database)
    with engine.begin() as connection:
        connection.execute(text("INSERT INTO paths (path_id) VALUES ('P')"))
        connection.execute(
            text("INSERT INTO profile_points (path_id, point, x_m, y_m) VALUES ('P', 0, 1, 2)")
        )
    engine.dispose()
    add_old_revision(monkeypatch, tmp_path)
    with pytest.raises(AvahazardError) as caught, reading(any_database):
        pass
    assert "avahazard db upgrade" in caught.value.hint
    with pytest.raises(AvahazardError, match="older version"):
        upkeep.create(any_database)
    assert upkeep.status(any_database).state == "old"
    assert upkeep.upgrade(any_database) == "old"
    assert upkeep.upgrade(any_database) == "current"
    with reading(any_database) as session:  # and the children of a changed table are there
        assert session.scalar(text("SELECT count(*) FROM profile_points")) == 1


def test_revisions_are_those_that_alembic_finds() -> None:
    script = ScriptDirectory.from_config(tables._config())
    assert tables.head() == script.get_current_head()
    assert tables._revisions() == {r.revision: r.down_revision for r in script.walk_revisions()}
