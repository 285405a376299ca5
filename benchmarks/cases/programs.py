"""Small commands as whole processes, and the import of many rows."""

from __future__ import annotations

import sqlite3
import sys
import tempfile
from collections.abc import Callable
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
import pandas as pd

from avahazard.workflow.database import import_files, init_database
from benchmarks.measuring import Row, alternate, processes, seconds

PROGRAM = str(Path(sys.executable).parent / "avahazard")
N_ROWS, N_PATHS = 200_000, 1000


def help() -> Row:
    """`avahazard --help` against importing typer."""
    return processes([PROGRAM, "--help"], [sys.executable, "-c", "import typer"])


def small() -> Row:
    """`avahazard paths` on the demo data against importing SQLAlchemy."""
    with tempfile.TemporaryDirectory() as folder:
        command = [PROGRAM, "--db", demo(folder), "paths"]
        return processes(command, [sys.executable, "-c", "import sqlalchemy"])


def demo(folder: str) -> str:
    """A database with the records of the demo."""
    database = str(Path(folder) / "demo.db")
    init_database(database)
    with as_file(files("avahazard.data")) as data:
        names = ("paths.csv", "profiles.csv", "events.csv")
        import_files(database, [data / name for name in names])
    return database


def import_rows() -> Row:
    """Event rows into SQLite, all checks on, against executemany of the same rows."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write(folder)
        begun = folder / "begun.db"
        init_database(str(begun))
        import_files(str(begun), [folder / "paths.csv", folder / "profiles.csv"])

        def ours(target: Path = folder / "ours.db") -> float:
            _remove(target)
            target.write_bytes(begun.read_bytes())
            return seconds(lambda: import_files(str(target), [folder / "events.csv"]))

        ours()
        ratio, a, b = alternate(ours, _rival(folder), 3)
    note = (
        f"{N_ROWS} events of six columns on {N_PATHS} paths, one of them a column of text, "
        "which is stored as a row of its own; the rival has the rows ready in memory."
    )
    return ratio, 1e6 * a / N_ROWS, 1e6 * b / N_ROWS, note


def _write(folder: Path) -> None:
    rng, k = np.random.default_rng(0), np.arange(N_ROWS)
    x = np.arange(0.0, 3000.0, 250.0)
    names = pd.Series(np.arange(N_PATHS)).map("P{}".format)
    tables = {
        "paths": pd.DataFrame({"path_id": names, "release_elevation_m": 2400}),
        "profiles": pd.DataFrame(
            {"path_id": names.repeat(len(x)), "x_m": np.tile(x, N_PATHS)}
        ).assign(y_m=lambda t: 2500.0 - 0.9 * t.x_m + 1.2e-4 * t.x_m**2),
        "events": pd.DataFrame(
            {
                "event_id": [f"E{i}" for i in k],
                "path_id": names.to_numpy()[k % N_PATHS],
                "date": [f"{1900 + i % 120}-02-{1 + i % 28:02d}" for i in k],
                "runout_elevation_m": rng.uniform(960.0, 1500.0, N_ROWS).round(1),
                "volume_m3": rng.lognormal(10.0, 1.0, N_ROWS).round(),
                "snow_type": rng.choice(["dry", "wet"], N_ROWS),
            }
        ),
    }
    for name, table in tables.items():
        table.to_csv(folder / f"{name}.csv", index=False)


def _rival(folder: Path) -> Callable[[], float]:
    """Insert what our database holds of the events into tables like its own."""
    tables = ("events", "event_covariates")
    query = (
        "SELECT sql FROM sqlite_master WHERE tbl_name IN (?, ?) AND sql IS NOT NULL "
        "ORDER BY type DESC"
    )
    with sqlite3.connect(folder / "ours.db") as source:
        made = [text for (text,) in source.execute(query, tables)]
        rows = {table: source.execute(f"SELECT * FROM {table}").fetchall() for table in tables}

    def insert(target: Path = folder / "theirs.db") -> float:
        _remove(target)
        with sqlite3.connect(target) as connection:
            connection.execute("PRAGMA journal_mode = WAL")
            for text in made:
                connection.execute(text)

            def all_rows() -> None:
                for table, of_table in rows.items():
                    marks = ",".join("?" * len(of_table[0]))
                    connection.executemany(f"INSERT INTO {table} VALUES ({marks})", of_table)
                connection.commit()

            return seconds(all_rows)

    return insert


def _remove(database: Path) -> None:
    for suffix in ("", "-wal", "-shm"):
        Path(f"{database}{suffix}").unlink(missing_ok=True)
