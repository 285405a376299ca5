"""The command avahazard as a process: its words, its progress, what it says when it fails.

Nothing here needs QGIS.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from queue import Empty, Queue
from typing import Any

PROGRESS = re.compile(r"^(?P<what>.*?): (?P<share>\d+)%")
POLL_S = 0.2


class CommandError(Exception):
    """What the command said when it failed, with its hint."""


def find_command(named: str = "") -> str:
    """The command: that which is named, else the one on the PATH.

    Raises:
        CommandError: there is none.
    """
    found = shutil.which(named or "avahazard")
    if found is None:
        raise CommandError(
            f"The command {named or 'avahazard'} was not found. Install avahazard, and name its "
            "command in Settings > Options > Processing > Providers > avahazard."
        )
    return found


def words_of(command: str, database: str, words: Sequence[object]) -> list[str]:
    """The words of a process; what is None or empty is left out with its option before it."""
    given = [str(word) for word in words]
    return [command, "--db", database, "--json", *given]


def option(flag: str, value: object) -> list[str]:
    """An option with its value; nothing where there is none. A list gives it several times."""
    if value in (None, "", []):
        return []
    values = value if isinstance(value, list) else [value]
    return [word for one in values for word in (flag, str(one))]


def progress_of(line: str) -> tuple[str, int] | None:
    """The progress in a line of standard error, and its share in per cent; else None."""
    found = PROGRESS.match(line.strip())
    return None if found is None else (found["what"], int(found["share"]))


def run(
    words: Sequence[str],
    tell: Callable[[str], None] = lambda _line: None,
    progress: Callable[[str, int], None] = lambda _what, _share: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Any:
    """Run the command, and return the document that it prints; None where it was cancelled.

    Raises:
        CommandError: it failed.
    """
    # QGIS has its own Python packages on the path of its processes.
    unwanted = ("PYTHONHOME", "PYTHONPATH")
    environment = {k: v for k, v in os.environ.items() if k not in unwanted}
    process = subprocess.Popen(
        list(words),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env={**environment, "PYTHONIOENCODING": "utf-8"},
    )
    lines: Queue[str] = Queue()
    printed: list[str] = []
    readers = (
        threading.Thread(target=lambda: [lines.put(line) for line in process.stderr]),
        threading.Thread(target=lambda: printed.append(process.stdout.read())),
    )
    for reader in readers:
        reader.start()
    said: list[str] = []
    while any(reader.is_alive() for reader in readers) or not lines.empty():
        if cancelled():
            process.kill()
            process.wait()
            return None
        try:
            line = lines.get(timeout=POLL_S).rstrip()
        except Empty:
            continue
        if (share := progress_of(line)) is not None:
            progress(*share)
        elif line:
            said.append(line)
            tell(line)
    if process.wait() != 0:
        raise CommandError("\n".join(said) or f"avahazard ended with status {process.returncode}.")
    return json.loads(printed[0]) if printed and printed[0].strip() else None


def import_words(sources: Sequence[str], dem: str, update: bool) -> list[str]:
    """Import files or folders, lines on a terrain model."""
    return ["import", *sources, *option("--dem", dem), *(["--update"] if update else [])]


def calibrate_words(name: str, effects: str, forward: str) -> list[str]:
    """Calibrate a model with effects, a list with commas, on the block or a flow model."""
    keys = [key.strip() for key in effects.split(",") if key.strip()]
    return ["calibrate", name, *option("--with", keys), *option("--forward", forward)]


def hazard_words(name: str, periods: str) -> list[str]:
    """Design runouts of return periods, a list with commas."""
    years = [year.strip() for year in periods.split(",") if year.strip()]
    return ["hazard", name, *option("-T", years)]


def map_words(name: str, file: str, limits: str) -> list[str]:
    """A map of annual chances, or of areas and zones."""
    return ["map", name, "-o", file, *option("--limits", limits)]


def report_words(name: str, file: str, language: str, title: str) -> list[str]:
    """The report as one file of HTML."""
    return ["report", name, "-o", file, *option("--language", language), *option("--title", title)]


def is_new(database: str) -> bool:
    """Whether a database has to be made first."""
    return "://" not in database and not Path(database).exists()
