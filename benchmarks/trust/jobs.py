"""The commands that write, small enough to be killed hundreds of times."""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from alembic import command

from avahazard.store import schema, upkeep
from avahazard.store.session import make_engine
from avahazard.synth.making import make_world
from avahazard.synth.writing import write_world
from avahazard.workflow.import_files import import_files
from benchmarks.trust.running import run

OLD_REVISION = "0005"
"""From which `db upgrade` is killed: draws, results and bounds change their tables after it."""

PROJECT = """
files = ["world"]
skip = ["compare", "diagnose", "zones", "report"]
[model]
name = "whole"
chains = 2
draws = 100
[hazard]
return_periods = [30.0]
[export]
files = ["bounds.csv"]
"""


@dataclass(frozen=True, slots=True)
class Job:
    """A command, the `state` of the database that it starts from, and the `file` it writes."""

    name: str
    words: tuple[str, ...]
    state: str
    file: str | None = None
    on_server: bool = True


SAMPLED = ("--chains", "2", "--draws", "60")
JOBS = (
    Job("import", ("import", "world"), "empty"),
    Job("import --update", ("import", "changed", "--update"), "model"),
    Job("calibrate", ("calibrate", "second", *SAMPLED), "model"),
    Job("add", ("add", "base", "snow-type", "--as", "child"), "model"),
    Job("compare", ("compare", "base"), "model"),
    Job("diagnose", ("diagnose", "base", "--worlds", "39"), "model"),
    Job("hazard", ("hazard", "base", "--return-period", "30", "--draws", "2000"), "model"),
    Job("zones", ("zones", "base", "--return-period", "30"), "model"),
    Job("run", ("run", "avahazard.toml"), "empty"),
    Job("db upgrade", ("db", "upgrade"), "old"),
    Job("db backup", ("db", "backup", "copy.db"), "model", "copy.db", on_server=False),
    Job("report", ("report", "base", "-o", "report.html"), "answered", "report.html"),
    Job("export .csv", ("export", "base", "-o", "bounds.csv"), "answered", "bounds.csv"),
)
SHORT = ("import", "calibrate", "compare", "hazard", "db upgrade", "export .csv")
"""The jobs of the short run in the tests."""


def write_records(folder: Path) -> None:
    """Write the records that the jobs work on: `world`, `changed` ones, and a project."""
    records, truth = make_world(3, 16, 2, {})
    write_world(folder / "world", records, truth)
    (folder / "changed").mkdir()
    events = (folder / "world" / "events.csv").read_text(encoding="utf-8")
    # Every tenth of a metre counts: each row is another one, and still on its path.
    moved = re.sub(r"(?<=,,)(\d+)\.\d+", r"\1.5", events)
    (folder / "changed" / "events.csv").write_text(moved, encoding="utf-8")
    (folder / "avahazard.toml").write_text(PROJECT, encoding="utf-8")


def write_databases(folder: Path) -> tuple[str, str]:
    """Write the records, a database with them, and an empty one; return where these two are."""
    write_records(folder)
    database, empty = str(folder / "records.db"), str(folder / "empty.db")
    upkeep.create(empty)
    shutil.copy(empty, database)
    import_files(database, [folder / "world"])
    return database, empty


def make_state(state: str, database: str, folder: Path) -> None:
    """Bring the missing or empty `database` to a state that jobs start from."""
    upkeep.create(database)
    steps: dict[str, tuple[tuple[str, ...], ...]] = {
        "empty": (),
        "model": (("import", "world"), ("calibrate", "base", *SAMPLED)),
    }
    answer = next(job.words for job in JOBS if job.name == "hazard")
    steps["answered"] = (*steps["model"], answer)
    steps["old"] = steps["answered"]
    for words in steps[state]:
        run(database, words, folder).check()
    if state == "old":
        downgrade(database, OLD_REVISION)


def downgrade(database: str, revision: str) -> None:
    """Give a database the schema of an earlier revision; what that had no place for is lost."""
    engine = make_engine(database, migrates=True).execution_options(writes=True)
    with engine.begin() as connection:
        config = schema._config()
        config.attributes["connection"] = connection
        command.downgrade(config, revision)
    engine.dispose()
