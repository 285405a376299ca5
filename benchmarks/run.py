"""Measure ours against the rivals; writes results.jsonl and the tables of docs/benchmarks.md.

make bench                      all of them
… -m benchmarks.run NAME…       some of them; the other rows stay as they were measured
"""

from __future__ import annotations

import importlib
import os
import platform
import sys
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from benchmarks.study import DOCS, HERE, Line, bullets, keep, lines, table, write_parts

RESULTS = HERE / "results.jsonl"


class Target(NamedTuple):
    """A row: the module of its case, what its ratio must reach, its unit, what the ratio is."""

    module: str
    target: float
    unit: str
    ratio: str
    at_most: bool = False

    def reached(self, ratio: float) -> bool:
        """Whether the target is met."""
        return ratio <= self.target if self.at_most else ratio >= self.target

    @property
    def bound(self) -> str:
        """The target with its sign."""
        return f"{'≤' if self.at_most else '≥'} {self.target:g}"


RUNS, SOLVER = "ms per 1000 runs", "time of `solve_ivp` (DOP853, event, rtol 1e-8) over ours"
LOOP = "time of a bare compiled loop of the same multiply-adds over ours"
ESS = "smallest ESS per second"
DIAGNOSIS = ("s per diagnosis", "time of a diagnosis over a minute", True)
ROWS = {
    "run": Target("blocks", 310_000, RUNS, SOLVER),
    "run_limit": Target("blocks", 0.5, f"CPU-{RUNS}", LOOP),
    "run_effects": Target("blocks", 400_000, RUNS, SOLVER),
    "run_speed": Target("blocks", 23_000, RUNS, SOLVER),
    "run_limit_ground": Target("blocks", 0.3, f"CPU-{RUNS}", LOOP),
    "mh_emcee": Target("samplers", 47, ESS, f"our {ESS} over emcee's"),
    "marginal_nuts": Target("marginal_nuts", 70, ESS, f"our {ESS} over that of NumPyro's NUTS"),
    "gibbs_limit": Target(
        "samplers", 0.63, "ns per iteration", "time of the random numbers alone over ours"
    ),
    "draws_limit": Target(
        "samplers", 2.5, "s per 1e7 draws", "time of `standard_normal` and `numpy.interp` over ours"
    ),
    "evidence": Target(
        "evidence", 200, "s an evidence", "time of dynesty's nested sampling over ours"
    ),
    "help": Target(
        "programs", 1.5, "s per process",
        'time of `avahazard --help` over that of `python -c "import typer"`', True,
    ),
    "small": Target(
        "programs", 2.5, "s per process",
        'time of `avahazard paths` over that of `python -c "import sqlalchemy"`', True,
    ),
    "import_rows": Target(
        "programs", 0.25, "µs a row",
        "time of `sqlite3` executemany of the same rows, unchecked, over ours",
    ),
    "diagnose": Target("diagnoses", 1, *DIAGNOSIS),
    "diagnose_speeds": Target("diagnoses", 1, *DIAGNOSIS),
    "diagnose_records": Target(
        "diagnoses", 1, "CPU-s", "time of a diagnosis over five minutes", True
    ),
    "hazard_path": Target(
        "regions", 7, "CPU-s a path", "time of an earlier version (0.35 s) over ours"
    ),
    "workers": Target("regions", 1.7, "s", "time of one process over that of two"),
    "compare_paths": Target(
        "regions", 15, "CPU-s", "time of an earlier version (486 s, a fit for each path) over ours"
    ),
    "scaling": Target("regions", 11, "CPU-s", "time of 10000 paths over that of 1000", True),
    "events": Target("regions", 11, "CPU-s", "time of 20000 events over that of 2000", True),
}  # fmt: skip


def main(names: list[str]) -> None:
    """Measure the named cases, each written down as soon as it is known."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # one core for everybody
    lacking = []
    for name in names or ROWS:
        row = ROWS[name]
        try:
            case = importlib.import_module(f"benchmarks.cases.{row.module}")
            ratio, ours, theirs, note = getattr(case, name)()
        except (SystemExit, ImportError) as reason:  # no such rival: its row stays as it was
            lacking.append(f"{name} was not measured. {reason}")
            continue
        verdict = "reached" if row.reached(ratio) else "MISSED"
        sides = f"ours {number(ours)}, theirs {number(theirs)} {row.unit}"
        print(f"{name:16} {number(ratio):>9}  ({row.bound}: {verdict})  {sides}", flush=True)
        found = {"name": name, "ratio": ratio, "ours": ours, "theirs": theirs, "note": note}
        keep(RESULTS, {**found, "machine": machine()})
        write_parts(DOCS / "benchmarks.md", parts(lines(RESULTS)))
    if lacking:
        raise SystemExit("\n".join(lacking))


def number(value: float) -> str:
    """Three significant digits, no exponent for what people can read."""
    return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"


def parts(measured: list[Line]) -> dict[str, str]:
    """The table of the page, the notes on its rows, and the machines."""
    found = {line["name"]: line for line in measured}
    rows, notes = [], []
    for name, row in ROWS.items():
        if name in found:
            ratio, ours, theirs = (found[name][key] for key in ("ratio", "ours", "theirs"))
            reached = "yes" if row.reached(ratio) else "**no**"
            sides = (number(ratio), row.bound, reached, number(ours), number(theirs))
            rows.append((f"`{name}`", *sides, row.unit, row.ratio))
            notes.append(f"`{name}`: {found[name]['note']}")
    head = ("name", "ratio", "target", "reached", "ours", "theirs", "unit", "the ratio is")
    machines = dict.fromkeys(line["machine"] for line in measured)
    return {
        "rows": table(head, rows),
        "notes": bullets(notes, "") + "\n\nMeasured on: " + "; ".join(machines) + ".",
    }


def machine() -> str:
    """Processor and versions that the figures depend on."""
    info = Path("/proc/cpuinfo")
    text = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    models = [line.split(":")[1].strip() for line in text if line.startswith("model name")]
    packages = ", ".join(
        f"{name} {version(name)}"
        for name in ("numpy", "scipy", "numba", "emcee", "numpyro", "dynesty")
        if find_spec(name) is not None
    )
    processor = models[0] if models else platform.machine()
    return f"{processor}, {platform.system()}, Python {platform.python_version()}, {packages}"


if __name__ == "__main__":
    main(sys.argv[1:])
