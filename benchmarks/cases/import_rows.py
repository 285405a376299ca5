"""Import of event rows into SQLite, all checks on, against executemany of the same rows."""

from __future__ import annotations

import csv
import sqlite3
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from avahazard.workflow.database import init_database
from avahazard.workflow.import_files import import_files
from benchmarks.measuring import Result, alternate, seconds

N_ROWS, N_PATHS = 200_000, 1000


def measure() -> Result:
    """Seconds of N_ROWS rows; paths and profiles are there already."""
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
        found, rival, ratio = alternate(ours, _rival(folder), 3)
    return Result(
        ratio,
        1e6 * found / N_ROWS,
        1e6 * rival / N_ROWS,
        "µs a row",
        0.25,
        False,
        "time of `sqlite3` executemany of the same rows, unchecked, over ours",
        f"{N_ROWS} events of six columns on {N_PATHS} paths, a column of words among them, which "
        "is a row of its own; the rival has the rows ready in memory.",
    )


def _write(folder: Path) -> None:
    rng = np.random.default_rng(0)
    x = np.arange(0.0, 3000.0, 250.0)
    y = 2500.0 - 0.9 * x + 1.2e-4 * x**2
    paths = [(f"P{k}", 2400) for k in range(N_PATHS)]
    points = [(name, *point) for name, _ in paths for point in zip(x, y, strict=True)]
    events = [
        (f"E{k}", f"P{k % N_PATHS}", f"{1900 + k % 120}-02-{1 + k % 28:02d}", *values)
        for k, values in enumerate(
            zip(
                rng.uniform(960.0, 1500.0, N_ROWS).round(1).tolist(),
                rng.lognormal(10.0, 1.0, N_ROWS).round().tolist(),
                rng.choice(["dry", "wet"], N_ROWS).tolist(),
                strict=True,
            )
        )
    ]
    columns = ("event_id", "path_id", "date", "runout_elevation_m", "volume_m3", "snow_type")
    for name, head, rows in (
        ("paths", ("path_id", "release_elevation_m"), paths),
        ("profiles", ("path_id", "x_m", "y_m"), points),
        ("events", columns, events),
    ):
        with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([head, *rows])


def _rival(folder: Path) -> Callable[[], float]:
    """Insert what our database holds of the events into tables like its own."""
    with sqlite3.connect(folder / "ours.db") as source:
        tables = ("events", "event_covariates")
        made = [
            text
            for (text,) in source.execute(
                "SELECT sql FROM sqlite_master WHERE tbl_name IN (?, ?) AND sql IS NOT NULL "
                "ORDER BY type DESC",
                tables,
            )
        ]
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
