"""Mutation testing of what computes: which small changes of the code do the tests not see?"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.trust.code_changes import TRUE_CODE, Change, changes_of, names_in_kernels

ROOT = Path(__file__).resolve().parents[2]
TESTED = {
    "physics": ("avahazard/physics", "tests/physics"),
    "likelihood": ("avahazard/inference/likelihood", "tests/inference/likelihood"),
    "hazard": ("avahazard/hazard", "tests/hazard"),
}
"""The parts of the program whose code is changed, and the tests that mirror them."""
UNCOMPILED = (
    *(f"tests/physics/test_{name}.py" for name in (
        "band_forms", "block", "cell_motion", "cell_step", "contact", "mean_friction", "near_stops",
        "point_error", "runout_curve", "speed", "stop_place",
    )),
    *(f"tests/inference/likelihood/test_{name}.py" for name in (
        "density_sums", "event_terms", "exponentials", "gauss_quadrature", "group_offsets",
        "interpolation", "nodes", "offset_system", "panels", "record_density",
        "speed_bounds", "speed_errors", "speed_nodes", "straight_density",
    )),
    *(f"tests/hazard/test_{name}.py" for name in (
        "alpha_beta_on_points", "exceedance", "passing", "runout_bounds", "shape_grid",
    )),
    *(f"tests/hazard/zones/test_{name}.py" for name in (
        "exceeded_speeds", "pieces", "rate_curves",
    )),
)  # fmt: skip
"""The tests of kernels by themselves; those of all that stands on kernels would take hours."""
ELSEWHERE = tuple(f"tests/{name}" for name in (
    "api", "cli", "criticism", "effects", "engine", "inference/fitting", "inference/model",
    "inference/prediction", "inference/samplers", "records", "report", "results", "synth",
    "workflow",
))  # fmt: skip
"""Tests of what stands on the parts: what those of a part by itself do not see, these may."""
MOST_TEST_S = 4.0
"""CPU that one test may take; without the compiler some would take minutes."""
MOST_S = 40.0
"""CPU of all tests that one change is tried on; those of the module's own file come first."""


@dataclass(frozen=True, slots=True)
class Covered:
    """What the tests run of the true code: a test's CPU, and the tests of each line."""

    seconds: dict[str, float]
    lines: dict[str, dict[int, list[str]]]

    def tests_of(self, change: Change) -> list[str]:
        """The tests that run a changed line: the module's own first, then the quick ones."""
        own = f"test_{Path(change.module).stem}.py"
        lines = self.lines.get(change.module, {})
        # A line within a statement may have no code of its own; the statement begins above it.
        above = [line for line in lines if line <= change.line]
        contexts = lines[max(above)] if above else []
        if (
            contexts == [""] or not change.where
        ):  # run on import: whatever runs the module may see it
            contexts = [name for names in lines.values() for name in names]
            contexts += [t for t in self.seconds if f"/{own}::" in t]  # its constants alone
        wanted = set(contexts)
        found = [t for t in self.seconds if t in wanted or t.partition("::")[0] in wanted]
        found.sort(key=lambda t: (f"/{own}::" not in t, self.seconds[t]))
        total = np.cumsum([self.seconds[t] for t in found])
        return [t for t, s in zip(found, total, strict=True) if s <= MOST_S or t == found[0]]


def all_changes() -> list[Change]:
    """Every change of the tested parts, module by module."""
    modules = {
        str(f.relative_to(ROOT)): f.read_text(encoding="utf-8")
        for f in sorted((ROOT / "avahazard").rglob("*.py"))
    }
    in_kernels = names_in_kernels(modules.values())
    return [
        change
        for folder, _ in TESTED.values()
        for module, source in modules.items()
        if module.startswith(f"{folder}/")
        for change in changes_of(module, source, in_kernels)
    ]


def sampled(changes: Sequence[Change], n: int, rng: np.random.Generator) -> list[Change]:
    """About n of the changes, each as likely as any other, spread evenly over the modules."""
    n = min(n, len(changes))
    shuffled = [changes[k] for k in rng.permutation(len(changes))]
    in_order = sorted(shuffled, key=lambda change: change.module)
    every = len(changes) / n
    first = rng.uniform(0.0, every)
    return [in_order[int(first + k * every)] for k in range(n)]


def covered(tests: Sequence[str] = (), *, compiled: bool) -> Covered:
    """Run these tests on the true code, else those of the parts: all, or without the compiler
    those of kernels by themselves."""
    parts = [mirror for _, mirror in TESTED.values()] if compiled else UNCOMPILED
    given = {
        "folders": [folder for folder, _ in TESTED.values()],
        "tests": list(tests or parts),
        "most_s": MOST_TEST_S,
    }
    (found,) = _worker("cover", given, compiled=compiled)
    failed = set(found["failed"])
    return Covered(
        {test: s for test, s in found["seconds"].items() if test not in failed},
        {
            module: {int(line): names for line, names in lines.items()}
            for module, lines in found["lines"].items()
        },
    )


def tried(
    changes: Sequence[Change], tests: Covered, *, compiled: bool
) -> Iterator[tuple[Change, str, float]]:
    """How the tests of each change end, and their CPU: killed, too long, survived, no test.

    Raises `SystemExit` where the tests of every fortieth change fail on the true code as well.
    """
    asked: dict[tuple[str, int], tuple[Change, dict[str, Any]]] = {}
    for change in changes:
        mine = tests.tests_of(change)
        if not mine:
            yield change, "no test", 0.0
            continue
        asked[change.module, change.number] = (
            change,
            {
                "module": change.module,
                "number": change.number,
                "tests": mine,
                "seconds": sum(tests.seconds[t] for t in mine),
            },
        )
    ones = [one for _, one in asked.values()]
    right = [{**one, "number": TRUE_CODE} for one in ones[::40]]
    for found in _worker("try", [*right, *ones], compiled=compiled) if ones else ():
        if found["number"] != TRUE_CODE:
            yield asked[found["module"], found["number"]][0], found["ended"], found["cpu"]
        elif found["ended"] != "survived":
            raise SystemExit(f"the tests of {found['module']} fail on the true code")


def _worker(what: str, given: object, *, compiled: bool) -> Iterator[Any]:
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "0" if compiled else "1"}
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.trust.code_worker", what],
        cwd=ROOT,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(json.dumps(given))
    process.stdin.close()
    yield from map(json.loads, process.stdout)
    if process.wait() != 0:
        raise SystemExit(f"the worker ended with {process.returncode}")
