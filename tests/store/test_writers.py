"""Writers at one moment: they come one after the other, and nobody is refused."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

from alembic import command
from sqlalchemy import text

from avahazard.store import schema, upkeep
from avahazard.store.engine import make_engine
from avahazard.store.session import reading, writing
from avahazard.workflow.database import upgrade_database

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
        config = schema._config()
        config.attributes["connection"] = connection
        command.downgrade(config, revision)
    engine.dispose()


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
    assert found.backup == f"{database}.before-{schema.head()}"
    assert upkeep.status(found.backup).revision == "0005"
    downgraded(database, "0005")
    assert upgrade_database(database).backup == f"{database}.before-{schema.head()}-2"
    assert upgrade_database(database).backup is None
    assert Path(found.backup).is_file()
