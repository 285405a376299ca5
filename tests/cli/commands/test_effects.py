"""`avahazard effects`."""

from __future__ import annotations

from tests.cli.commands.snow import document, run


def test_the_catalogue_beside_the_data(snow_database: str) -> None:
    rows = document(snow_database, "effects")
    assert {"key", "meaning", "needs", "lacking"} == set(rows[0])
    table = run(snow_database, "effects").stdout
    for key in ("turbulent-drag", "snow-type", "leading-edge"):
        assert key in table
    assert max(map(len, table.splitlines())) <= 80


def test_without_a_database(tmp_path: object) -> None:
    done = run(f"{tmp_path}/none.db", "effects")
    assert done.exit_code == 0
    assert "there are no events yet" in " ".join(done.stdout.split())
