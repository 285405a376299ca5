"""Records that tell next to nothing, before every command: no traceback, no NaN."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

from avahazard.synth.making import make_world
from avahazard.synth.writing import write_world
from benchmarks.trust.chain import SAMPLED, Chained, chain

Row = dict[str, str]
Change = Callable[[list[Row]], list[Row]]


def _with(rows: list[Row], **given: str) -> list[Row]:
    return [row | given for row in rows]


def _left(rows: list[Row]) -> list[Row]:
    return _with(rows, left_profile="1", runout_x_m="", runout_elevation_m="")


def _no_volumes(rows: list[Row]) -> list[Row]:
    kept = [name for name in rows[0] if name != "volume_m3" and not name.startswith("deposit_")]
    return [{name: row[name] for name in kept} for row in rows]


def _volumes(text: str) -> Change:
    def change(rows: list[Row]) -> list[Row]:
        return [row | {"volume_m3": text} for row in _no_volumes(rows)]

    return change


SETS: dict[str, Change] = {
    "one event": lambda rows: rows[:1],
    "two events": lambda rows: rows[:2],
    "one event that left": lambda rows: _left(rows[:1]),
    "all left the profile": _left,
    "all volumes equal": _volumes("30000"),
    "no volumes": _no_volumes,
    "one stop many times": lambda rows: [rows[0] | {"event_id": f"e{k}"} for k in range(len(rows))],
    "vague stops": lambda rows: _with(rows, runout_sigma_m="5000"),
    "exact stops": lambda rows: _with(rows, runout_sigma_m="0.001", volume_rel_sigma="0.001"),
    "all on one day": lambda rows: _with(rows, date="1999-02-09"),
    "no dates": lambda rows: _with(rows, date=""),
}
METHODS = ("marginal", "metropolis", "gibbs")
LAWS = ("exponential", "power", "rational", "asymptotic", "constant")


def steps(*, every: bool) -> tuple[tuple[str, ...], ...]:
    """All commands on a set; not `every` method and law in a short run."""
    commands: list[tuple[str, ...]] = [
        ("fit",),
        ("friction",),
        ("volumes",),
        ("calibrate", "m", *SAMPLED),
    ]
    if every:
        draws = ("--chains", "2", "--draws", "200")
        commands += [("calibrate", f"by-{m}", "--method", m, *draws) for m in METHODS[1:]]
        commands += [("calibrate", law, "--law", law, *SAMPLED) for law in LAWS]
        commands += [("diagnose", "m", "--worlds", "39"), ("alpha-beta",)]
        commands += [("friction", "--model", "m")]
    commands += [
        ("compare", "m"),
        ("hazard", "m", "--return-period", "30", "--volume", "20000", "--draws", "1000"),
        ("zones", "m", "--return-period", "30"),
        ("model", "m"),
        ("ladder",),
    ]
    return tuple(("--json", *words) for words in commands)


def run_set(name: str, database: str, folder: Path, *, every: bool = True) -> Chained:
    """Run all commands on one of `SETS`; `database` is empty, and in `folder`."""
    records, truth = make_world(3, 16, 2, {})
    write_world(folder / "world", records, truth)
    file = folder / "world" / "events.csv"
    with file.open(encoding="utf-8", newline="") as text:
        rows = SETS[name](list(csv.DictReader(text)))
    made = io.StringIO()
    writer = csv.DictWriter(made, rows[0], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    file.write_text(made.getvalue(), encoding="utf-8")
    return chain(name, database, ["world"], folder, steps(every=every))
