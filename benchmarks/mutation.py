"""Mutation testing by cosmic-ray: a sample of mutants of what computes, each tried on its tests.

make mutation [MUTANTS=60] [SEED=1]

The tests of a module are its mirror under tests/ (else the mirrored folder), without the slow ones.
Modules with kernels are tried with the JIT off, as cached compiled code would hide a mutant.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import cosmic_ray.commands
from cosmic_ray.mutating import mutate_and_test
from cosmic_ray.testing import run_tests
from cosmic_ray.work_db import WorkDB, use_db
from cosmic_ray.work_item import MutationSpec, TestOutcome

ROOT = Path(__file__).resolve().parents[1]
PARTS = ("avahazard/physics", "avahazard/inference/likelihood", "avahazard/hazard")
LEFT_OUT = ("RemoveDecorator", "ExceptionReplacer", "BinaryOperator_BitOr_")
"""Operators that change no computation: the last one would change the unions of annotations."""
MOST_S = 300.0


def main() -> None:
    """Try the sample in a copy of the tree; print each outcome, and the share that is killed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mutants", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--parts", nargs="*", default=PARTS, help="folders or modules")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mutation-") as folder:
        copy_tree(Path(folder))
        os.chdir(folder)
        os.environ |= {"PYTHONPATH": folder, "NUMBA_CACHE_DIR": f"{folder}/cache"}
        with use_db("session.sqlite", WorkDB.Mode.create) as database:
            found = mutants(given.parts, database)
        print(f"{len(found)} mutants, seed {given.seed}")
        ends: Counter[str] = Counter()
        for one in random.Random(given.seed).sample(found, min(given.mutants, len(found))):
            end = tried(one)
            ends[end] += 1
            print(f"{end}: {one.module_path}:{one.start_pos[0]} {one.operator_name}", flush=True)
    counted = ends["killed"] + ends["survived"]
    print(f"{ends['killed']} of {counted} killed; {ends['no test']} without a quick test")


def copy_tree(folder: Path) -> None:
    """Copy what is tracked, as it stands."""
    names = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, check=True, text=True
    )
    for name in filter(lambda name: (ROOT / name).is_file(), names.stdout.splitlines()):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)


def mutants(parts: list[str], database: WorkDB) -> list[MutationSpec]:
    """All mutants of these folders or modules."""
    files = [f for part in parts for f in sorted(Path(part).rglob("*.py")) or [Path(part)]]
    cosmic_ray.commands.init(files, database, {})
    every = [one for item in database.work_items for one in item.mutations]
    return [one for one in every if not any(name in one.operator_name for name in LEFT_OUT)]


def tried(mutant: MutationSpec) -> str:
    """`killed`, `survived` or `no test`: none that passes on the true code within `MOST_S`."""
    module = mutant.module_path.relative_to("avahazard")
    mirror = Path("tests") / module.with_name(f"test_{module.name}")
    tests = mirror if mirror.exists() else mirror.parent
    uncompiled = "@kernel" in mutant.module_path.read_text(encoding="utf-8")
    os.environ["NUMBA_DISABLE_JIT"] = "1" if uncompiled else "0"
    options = "-x -q -p no:cacheprovider -m 'not slow' -W ignore::RuntimeWarning"
    command = f"{sys.executable} -m pytest {options} {tests}"
    began = time.monotonic()
    if run_tests(command, MOST_S)[0] != TestOutcome.SURVIVED:
        return "no test"
    took = time.monotonic() - began
    outcome = mutate_and_test([mutant], command, 3.0 * took + 30.0).test_outcome
    return "survived" if outcome == TestOutcome.SURVIVED else "killed"


if __name__ == "__main__":
    main()
