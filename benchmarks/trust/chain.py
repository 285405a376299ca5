"""The whole chain of commands on records that were accepted: no traceback, no NaN, no garbage."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from benchmarks.trust.running import Ran, run

GARBAGE = 1e12
"""No parameter of friction, and no spread, is as large."""
SAMPLED = ("--chains", "2", "--draws", "60")
Steps = tuple[tuple[str, ...], ...]
STEPS: Steps = (
    ("--json", "calibrate", "m", *SAMPLED),
    ("--json", "compare", "m"),
    ("--json", "hazard", "m", "--return-period", "30", "--volume", "20000", "--draws", "1000"),
    ("--json", "zones", "m", "--return-period", "30"),
    ("--json", "fit"),
    ("--json", "friction"),
    ("--json", "ladder"),
    ("--json", "export", "m", "-o", "bounds.csv"),
)


@dataclass(slots=True)
class Chained:
    """What came of one set of records: steps that succeeded, that were refused, and faults."""

    name: str
    done: int = 0
    refused: int = 0
    faults: list[str] = field(default_factory=list)


def chain(
    name: str,
    database: str,
    files: list[str],
    folder: Path,
    steps: Steps = STEPS,
) -> Chained:
    """Import `files` into an empty database and go on to the export."""
    found = Chained(name)
    for words in (("--json", "import", *files), *steps):
        with warnings.catch_warnings():
            # What numpy remarks on its way is no word for people, and hides what went wrong.
            warnings.simplefilter("error", RuntimeWarning)
            ran = run(database, words, folder)
        found.done += ran.status == 0
        found.refused += ran.status == 1
        found.faults += [f"{' '.join(words[1:3])}: {fault}" for fault in faults_of(ran)]
    return found


def faults_of(ran: Ran) -> Iterator[str]:
    """What is wrong with how a command with `--json` ended."""
    if ran.broken:
        yield ran.broken[:300]
    elif ran.status not in (0, 1):
        yield f"status {ran.status}: {ran.errors[:300]}"
    elif ran.status == 1:
        if "Error:" not in ran.errors:
            yield f"refused without a message: {ran.errors[:300]}"
    else:
        try:
            document = json.loads(ran.output, parse_constant=_no_number)
        except ValueError as error:
            yield f"no JSON document: {error}"
            return
        if ran.words[1] == "calibrate":
            yield from _unfounded(document)


def _unfounded(document: dict[str, Any]) -> Iterator[str]:
    """A calibration that calls itself converged on numbers that mean nothing, and has no note."""
    if not document["diagnostics"]["converged"]:
        return
    for name, found in document["parameters"].items():
        mean, sd = found["mean"], found["sd"]
        if mean is None or sd is None or not math.isfinite(mean) or not sd > 0.0:
            yield f"converged on {name} = {mean} ± {sd}"
        elif abs(mean) > GARBAGE or sd > GARBAGE:
            yield f"converged on {name} = {mean:g} ± {sd:g}"


def _no_number(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number")
