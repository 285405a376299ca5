"""Databases by path and by URL."""

from __future__ import annotations

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store.engine import database_name, database_url, make_engine


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
