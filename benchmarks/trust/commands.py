"""The commands that write, and how one is run: in this process, in one of its own, forked off."""

from __future__ import annotations

import contextlib
import os
import re
import select
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from alembic import command
from sqlalchemy import Connection, event
from sqlalchemy.engine import Engine
from typer.testing import CliRunner

from avahazard.cli.main import app
from avahazard.store import tables, upkeep
from avahazard.store.session import make_engine
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import write_dataset
from avahazard.workflow.database import import_files

PROGRAM = str(Path(sys.executable).with_name("avahazard"))
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
Words = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Job:
    """A command, the `state` of the database that it starts from, and the `file` it writes."""

    name: str
    words: Words
    state: str
    file: str | None = None
    on_server: bool = True


SAMPLED = ("--chains", "2", "--draws", "60")
HAZARD = ("hazard", "base", "--return-period", "30", "--draws", "2000")
JOBS = (
    Job("import", ("import", "world"), "empty"),
    Job("import --update", ("import", "changed", "--update"), "model"),
    Job("calibrate", ("calibrate", "second", *SAMPLED), "model"),
    Job("add", ("add", "base", "snow-type", "--as", "child"), "model"),
    Job("compare", ("compare", "base"), "model"),
    Job("diagnose", ("diagnose", "base"), "model"),
    Job("hazard", HAZARD, "model"),
    Job("zones", ("zones", "base", "--no-drag", "--return-period", "30"), "model"),
    Job("run", ("run", "avahazard.toml"), "empty"),
    Job("db upgrade", ("db", "upgrade"), "old"),
    Job("db backup", ("db", "backup", "copy.db"), "model", "copy.db", on_server=False),
    Job("report", ("report", "base", "-o", "report.html"), "answered", "report.html"),
    Job("export .csv", ("export", "base", "-o", "bounds.csv"), "answered", "bounds.csv"),
)
MODEL = (("import", "world"), ("calibrate", "base", *SAMPLED))
STATES = {"empty": (), "model": MODEL, "answered": (*MODEL, HAZARD), "old": (*MODEL, HAZARD)}


def write_records(folder: Path) -> None:
    """Write the records that the jobs work on: `world`, `changed` ones, and a project."""
    write_dataset(folder / "world", *make_dataset(3, 16, 2, {}))
    (folder / "changed").mkdir()
    events = (folder / "world" / "events.csv").read_text(encoding="utf-8")
    # Every tenth of a metre counts: each row is another one, and still on its path.
    moved = re.sub(r"(?<=,,)(\d+)\.\d+", r"\1.5", events)
    (folder / "changed" / "events.csv").write_text(moved, encoding="utf-8")
    (folder / "avahazard.toml").write_text(PROJECT, encoding="utf-8")


def link_records(folder: Path, inside: Path) -> Path:
    """Give a job in `inside`, made if need be, the records of `folder`."""
    inside.mkdir(exist_ok=True)
    for name in ("world", "changed"):
        (inside / name).symlink_to(folder / name)
    shutil.copy(folder / "avahazard.toml", inside)
    return inside


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
    for words in STATES[state]:
        run(database, words, folder).check()
    if state == "old":
        migrate(database, command.downgrade, OLD_REVISION)


def migrate(database: str, way, revision: str) -> None:
    """Up- or downgrade a database (`way`, of Alembic); what has no place there is lost."""
    engine = make_engine(database, migrates=True).execution_options(writes=True)
    with engine.begin() as connection:
        config = tables._config()
        config.attributes["connection"] = connection
        way(config, revision)
    engine.dispose()


@dataclass(frozen=True, slots=True)
class Ran:
    """How a command ended; `discontinuous` where it ended in a traceback."""

    words: Words
    status: int
    output: str
    errors: str
    discontinuous: str

    def check(self) -> Ran:
        """Return it, or stop where it did not succeed."""
        if self.status != 0:
            raise SystemExit(f"{' '.join(self.words)}: {self.errors or self.broken}")
        return self


def run(database: str, words: Words, folder: Path) -> Ran:
    """Run a command in this process, where kernels are warm, from `folder`."""
    with contextlib.chdir(folder):
        found = CliRunner().invoke(app, ["--db", database, *words], prog_name="avahazard")
    fault = found.exception
    discontinuous = "" if fault is None or isinstance(fault, SystemExit) else repr(fault)
    return Ran(words, found.exit_code, found.stdout, found.stderr, discontinuous)


def start(database: str, words: Words, folder: Path, **given: object) -> subprocess.Popen[str]:
    """Start a command in a process, and a group, of its own."""
    return subprocess.Popen(
        [PROGRAM, "--db", database, *words],
        **{"cwd": folder, "start_new_session": True, "text": True, "stdout": -1, "stderr": -1}
        | given,
    )


def ended(process: subprocess.Popen[str], words: Words) -> Ran:
    """Wait for a process that was started."""
    output, errors = process.communicate()
    discontinuous = errors if "Traceback" in errors else ""
    return Ran(words, process.returncode, output, errors, discontinuous)


@dataclass(slots=True)
class Forked:
    """A command forked off this process, in which the program is loaded and warm already.

    Each byte on `told` is a statement within a transaction that writes, or its commit, that it is
    about to send.
    """

    pid: int
    told: int
    status: int | None = None

    def ended(self) -> bool:
        """Whether it has ended, as `status` then says; a signal counts negative."""
        if self.status is None:
            pid, found = os.waitpid(self.pid, os.WNOHANG)
            self.status = os.waitstatus_to_exitcode(found) if pid else None
        return self.status is not None

    def end(self, signal: int | None = None) -> None:
        """Wait for its end, after a `signal` if one is given."""
        if not self.ended():
            if signal is not None:
                os.kill(self.pid, signal)
            self.status = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        os.close(self.told)

    def await_statements(self, n: int) -> None:
        """Return when `n` statements have been reported, or it has ended."""
        while n > 0 and (read := os.read(self.told, n)):
            n -= len(read)

    def count_statements(self) -> int:
        """Wait for its end, and return how many statements it reported."""
        n = 0
        while read := os.read(self.told, 65536):
            n += len(read)
        self.end()
        return n

    def sleep(self, seconds: float) -> None:
        """Let it go on for that long, or until it ends."""
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0 and not self.ended():
            select.select([], [], [], min(left, 0.002))


def fork(database: str, words: Words, folder: Path) -> Forked:
    """Start a command from `folder`, which does from its first moment what it is for."""
    told, tell = os.pipe()
    pid = os.fork()
    if pid:
        os.close(tell)
        return Forked(pid, told)

    def say(connection: Connection, *_: object) -> None:
        if connection.get_execution_options().get("writes", False):
            os.write(tell, b".")

    status = 70
    with contextlib.suppress(BaseException):
        os.close(told)
        for moment in ("before_cursor_execute", "commit"):
            event.listen(Engine, moment, say)
        status = run(database, words, folder).status
    os._exit(status)
