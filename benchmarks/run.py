"""Measure ours against the rivals and write results.json and docs/benchmarks.md.

make bench              all of them
… benchmarks/run.py NAME…    some of them; the other rows stay as they were measured
"""

from __future__ import annotations

import importlib
import json
import os
import platform
import sys
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"
HERE = Path(__file__).resolve().parent
RESULTS, PROFILES = HERE / "results.json", HERE / "profiles.md"
sys.path.insert(0, str(HERE.parent))

from benchmarks.measuring import Result  # noqa: E402

NAMES = (
    *("run", "run_limit", "run_effects", "run_speed", "run_limit_ground"),
    *("mh_emcee", "marginal_nuts", "gibbs_limit", "draws_limit", "evidence"),
    *("alpha_beta", "help", "small", "import_rows"),
    *("diagnose", "diagnose_speeds", "diagnose_records"),
    *("hazard_path", "workers", "compare_paths", "scaling", "events"),
)


def main(names: list[str]) -> None:
    """Measure the named cases, each written down as soon as it is known."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # one core for everybody
    lacking = []
    for name in names or NAMES:
        try:
            found = importlib.import_module(f"benchmarks.cases.{name}").measure()
        except SystemExit as reason:  # a rival that is not there: its row stays as it was
            lacking.append(f"{name} was not measured. {reason}")
            continue
        print(line(name, found), flush=True)
        write({**known(), name: found})
    if lacking:
        raise SystemExit("\n".join(lacking))


def known() -> dict[str, Result]:
    """The rows that were measured before."""
    rows = json.loads(RESULTS.read_text(encoding="utf-8"))
    return {name: Result(**row) for name, row in rows.items()}


def line(name: str, result: Result) -> str:
    """One row of the printed table."""
    bound = f"{'≤' if result.at_most else '≥'} {result.target:g}"
    verdict = "reached" if result.reached else "MISSED"
    sides = f"ours {number(result.ours)}, theirs {number(result.theirs)} {result.unit}"
    return f"{name:12} {number(result.ratio):>9}  ({bound}: {verdict})  {sides}"


def number(value: float) -> str:
    """Three significant digits, no exponent for what people can read."""
    return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"


def write(results: dict[str, Result]) -> None:
    """Write benchmarks/results.json and docs/benchmarks.md."""
    results = {name: results[name] for name in NAMES if name in results}
    plain = {name: result._asdict() for name, result in results.items()}
    words = json.dumps(plain, indent=2, ensure_ascii=False)
    RESULTS.write_text(words + "\n", encoding="utf-8")
    rows = [
        f"| `{name}` | {number(r.ratio)} | {'≤' if r.at_most else '≥'} {r.target:g} "
        f"| {'yes' if r.reached else '**no**'} | {number(r.ours)} | {number(r.theirs)} "
        f"| {r.unit} | {r.meaning} |"
        for name, r in results.items()
    ]
    notes = [f"- `{name}`: {r.note}" for name, r in results.items()]
    text = "\n".join(
        [
            "# Benchmarks",
            "",
            "Written by `make bench` (rivals in `.bench-venv`, an environment of their own). Both",
            "sides run in turn, A B A B, on one core; the ratio is the median of the rounds' "
            "ratios.",
            "",
            "| name | ratio | target | reached | ours | theirs | unit | the ratio is |",
            "|---|---|---|---|---|---|---|---|",
            *rows,
            "",
            *notes,
            "",
            f"Machine: {machine()}.",
            "",
            PROFILES.read_text(encoding="utf-8").rstrip(),
            "",
        ]
    )
    (HERE.parent / "docs" / "benchmarks.md").write_text(text, encoding="utf-8")


def machine() -> str:
    """Processor and versions that the figures depend on."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    models = [text.split(":")[1].strip() for text in lines if text.startswith("model name")]
    packages = ", ".join(
        f"{name} {version(name)}"
        for name in ("numpy", "scipy", "numba", "emcee", "numpyro", "dynesty")
        if find_spec(name) is not None
    )
    processor = models[0] if models else platform.machine()
    return f"{processor}, {platform.system()}, Python {platform.python_version()}, {packages}"


if __name__ == "__main__":
    main(sys.argv[1:])
