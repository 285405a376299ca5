"""Every command on records that were accepted: no traceback, no NaN, no garbage."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import pandas as pd

from avahazard.store import upkeep
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import write_dataset
from benchmarks.study import Line, bullets, table
from benchmarks.trust.commands import SAMPLED, Ran, Words, run

GARBAGE = 1e12
"""No parameter of friction, and no spread, is as large."""
HAZARD = ("hazard", "m", "--return-period", "30", "--volume", "20000", "--draws", "1000")
ZONES = ("zones", "m", "--no-drag", "--return-period", "30")
STEPS: tuple[Words, ...] = (
    ("calibrate", "m", *SAMPLED), ("compare", "m"), HAZARD, ZONES, ("fit",), ("friction",),
    ("ladder",), ("export", "m", "-o", "bounds.csv"),
)  # fmt: skip


@dataclass(slots=True)
class Chained:
    """What came of one set of records: steps that succeeded, that were refused, and faults."""

    name: str
    done: int = 0
    refused: int = 0
    faults: list[str] = field(default_factory=list)


def chain(
    name: str, database: str, files: list[str], folder: Path, steps: tuple[Words, ...] = STEPS
) -> Chained:
    """Import `files` into an empty database and go on to the export."""
    found = Chained(name)
    for words in (("import", *files), *steps):
        with warnings.catch_warnings():
            # What numpy remarks on its way is no word for people, and hides what went wrong.
            warnings.simplefilter("error", RuntimeWarning)
            ran = run(database, ("--json", *words), folder)
        found.done += ran.status == 0
        found.refused += ran.status == 1
        found.faults += [f"{' '.join(words[:2])}: {fault}" for fault in faults_of(ran)]
    return found


def faults_of(ran: Ran) -> Iterator[str]:
    """What is wrong with how a command with `--json` ended."""
    if ran.discontinuous:
        yield ran.discontinuous[:300]
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
        if ran.words[1] == "calibrate" and document["diagnostics"]["converged"]:
            for name, found in document["parameters"].items():
                mean, sd = found["mean"], found["sd"]
                if mean is None or sd is None or not math.isfinite(mean) or not sd > 0.0:
                    yield f"converged on {name} = {mean} ± {sd}"
                elif abs(mean) > GARBAGE or sd > GARBAGE:
                    yield f"converged on {name} = {mean:g} ± {sd:g}"


def _no_number(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number")


def _volumes(rows: pd.DataFrame, **given: str) -> pd.DataFrame:
    """The rows without columns of volumes, or with this one."""
    kept = [c for c in rows if c != "volume_m3" and not c.startswith("deposit_")]
    return rows[kept].assign(**given)


LEFT = {"left_profile": "1", "runout_x_m": "", "runout_elevation_m": ""}
SETS: dict[str, Callable[[pd.DataFrame], pd.DataFrame]] = {
    "one event": lambda rows: rows[:1],
    "two events": lambda rows: rows[:2],
    "one event beyond the profile": lambda rows: rows[:1].assign(**LEFT),
    "all beyond the profile": lambda rows: rows.assign(**LEFT),
    "all volumes equal": lambda rows: _volumes(rows, volume_m3="30000"),
    "no volumes": _volumes,
    "one repeated stop": lambda rows: rows.assign(
        **rows.iloc[0].drop("event_id"), event_id=[f"e{k}" for k in range(len(rows))]
    ),
    "imprecise stops": lambda rows: rows.assign(runout_sigma_m="5000"),
    "exact stops": lambda rows: rows.assign(runout_sigma_m="0.001", volume_rel_sigma="0.001"),
    "all on one day": lambda rows: rows.assign(date="1999-02-09"),
    "no dates": lambda rows: rows.assign(date=""),
}
LAWS = ("exponential", "power", "rational", "asymptotic", "constant")


def steps(*, every: bool) -> tuple[Words, ...]:
    """All commands on a set; not `every` method and law in a short run."""
    commands: list[Words] = [("fit",), ("friction",), ("volumes",), STEPS[0]]
    if every:
        draws = ("--chains", "2", "--draws", "200")
        for method in ("metropolis", "gibbs"):
            commands.append(("calibrate", f"by-{method}", "--method", method, *draws))
        commands += [("calibrate", law, "--law", law, *SAMPLED) for law in LAWS]
        commands += [("diagnose", "m"), ("alpha-beta",)]
        commands += [("friction", "--model", "m")]
    return (*commands, ("compare", "m"), HAZARD, ZONES, ("model", "m"), ("ladder",))


def run_set(name: str, database: str, folder: Path, *, every: bool = True) -> Chained:
    """Run all commands on one of `SETS`; `database` is empty, and in `folder`."""
    write_dataset(folder / "world", *make_dataset(3, 16, 2, {}))
    file = folder / "world" / "events.csv"
    SETS[name](pd.read_csv(file, dtype=str, keep_default_na=False)).to_csv(file, index=False)
    return chain(name, database, ["world"], folder, steps(every=every))


def degenerate(_given: Any, folder: Path) -> Line:
    """Every command on records that tell next to nothing."""
    rows, faults = [], []
    for name in SETS:
        inside = folder / name.replace(" ", "-")
        inside.mkdir()
        database = str(inside / "avahazard.db")
        upkeep.create(database)
        found = run_set(name, database, inside)
        print(found)
        faults += [f"{name}: {fault}" for fault in found.faults]
        rows.append({"set": name, "done": found.done, "refused": found.refused})
    return {"rows": rows, "faults": faults}


def page(found: Line) -> str:
    """A row for each set."""
    rows = [(row["set"], row["done"], row["refused"]) for row in found["rows"]]
    head = ("records", "commands that succeeded", "refused with a message")
    return f"{table(head, rows)}\n\n{bullets(found['faults'], 'No traceback, no NaN.')}"
