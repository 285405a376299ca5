"""A command of the program: in this process, where kernels are warm, or in one of its own."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from typer.testing import CliRunner

from avahazard.cli.main import app

PROGRAM = str(Path(sys.executable).with_name("avahazard"))


@dataclass(frozen=True, slots=True)
class Ran:
    """How a command ended; `broken` where it ended in a traceback."""

    words: tuple[str, ...]
    status: int
    output: str
    errors: str
    broken: str

    def check(self) -> Ran:
        """Return it, or stop where it did not succeed."""
        if self.status != 0:
            raise SystemExit(f"{' '.join(self.words)}: {self.errors or self.broken}")
        return self


def run(database: str, words: tuple[str, ...], folder: Path) -> Ran:
    """Run a command in this process, from `folder`."""
    with contextlib.chdir(folder):
        found = CliRunner().invoke(app, ["--db", database, *words], prog_name="avahazard")
    fault = found.exception
    broken = "" if fault is None or isinstance(fault, SystemExit) else repr(fault)
    return Ran(words, found.exit_code, found.stdout, found.stderr, broken)


def start(
    database: str, words: tuple[str, ...], folder: Path, **given: object
) -> subprocess.Popen[str]:
    """Start a command in a process, and a group, of its own."""
    return subprocess.Popen(  # type: ignore[call-overload,no-any-return]
        [PROGRAM, "--db", database, *words],
        cwd=folder,
        start_new_session=True,
        text=True,
        **{"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, **given},
    )


def ended(process: subprocess.Popen[str], words: tuple[str, ...]) -> Ran:
    """Wait for a process that was started with pipes."""
    output, errors = process.communicate()
    broken = errors if "Traceback" in errors else ""
    return Ran(words, process.returncode, output or "", errors or "", broken)
