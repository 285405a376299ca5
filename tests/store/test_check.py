"""Whether a database is whole (draws: test_draws)."""

from __future__ import annotations

import sqlite3

from avahazard.store.check import check_database
from avahazard.store.session import reading


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
