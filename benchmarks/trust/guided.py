"""Inputs of every form that a fuzzer guides to new branches of the readers, and what they do.

Needs atheris, which no lock has: `pip install --no-deps --target FOLDER atheris==3.0.0`, and
FOLDER in PYTHONPATH.
"""

from __future__ import annotations

import importlib.util
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

from avahazard.records.errors import AvahazardError
from avahazard.workflow.import_files import import_files
from benchmarks.trust.amounts import Amounts, Tell, cut
from benchmarks.trust.chain import STEPS
from benchmarks.trust.input_parts import chained
from benchmarks.trust.jobs import write_databases
from benchmarks.trust.readers import Read, read_one
from benchmarks.trust.rows import contents
from benchmarks.trust.sources import Source, sources

REACHED = re.compile(r"(INITED|DONE)\s+cov: (\d+)")
ROOT = Path(__file__).resolve().parents[2]
IMPORTED = 40
"""Inputs of each table that are imported in earnest: accepted ones, and kept ones refused."""
WITH_DIAGNOSIS = (*STEPS[:2], ("--json", "diagnose", "m", "--worlds", "39"), *STEPS[2:])
T = TypeVar("T")


def guided(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Guided inputs before the readers; imports in earnest and whole chains of some of them."""
    if importlib.util.find_spec("atheris") is None:
        raise SystemExit(str(__doc__))
    database, empty = write_databases(folder)
    forms = sources(folder)
    each = amounts.mutants // len(forms)
    n_chained = sum(source.chain for source in forms)
    rows, faults, imports, ends = [], [], [], []
    for k, source in enumerate(forms):
        row, found = fuzzed(source, each, amounts.seed, database, folder / f"guided-{k}")
        accepted, refused = _sorted_out(source, folder / f"guided-{k}", database)
        tell(f"{source.form}: {row} {found[:3]}")
        faults += [f"{source.form}: {fault}" for fault in found]
        if source.imported:
            some = evenly(accepted, IMPORTED // 2) + evenly(refused, IMPORTED // 2)
            whole = [fault for one in some for fault in in_earnest(source, one, database, folder)]
            imports += [f"{source.form}: {fault}" for fault in whole]
            row["imported"] = len(some)
            tell(f"{len(some)} imported {whole[:3]}")
        rows.append(row)
        n_chains = amounts.chains // n_chained if source.chain else 0
        for j, one in enumerate(evenly(accepted, n_chains)):
            ends.append(chained(source, j, one, empty, folder, WITH_DIAGNOSIS))
            tell(str(ends[-1]))
    return {
        "rows": rows,
        "faults": cut(faults),
        "import_faults": cut(imports),
        "chains": len(ends),
        "done": sum(one.done for one in ends),
        "refused": sum(one.refused for one in ends),
        "chain_faults": cut([f"{one.name}: {fault}" for one in ends for fault in one.faults]),
    }


def fuzzed(
    source: Source, n: int, seed: int, database: str, folder: Path
) -> tuple[dict[str, Any], list[str]]:
    """Counts and faults of `n` inputs of a form, read in a process of their own."""
    folder.mkdir()
    words = (source.form, str(n), str(seed), database, str(folder))
    ended = subprocess.run(
        [sys.executable, "-m", "benchmarks.trust.guided_worker", *words],
        cwd=ROOT, capture_output=True, text=True, errors="replace", check=False,
    )  # fmt: skip
    reached = dict(REACHED.findall(ended.stderr))
    counted = folder / "found.json"
    if not counted.exists() or "DONE" not in reached:
        return {"form": source.form}, [f"the process died: {ended.stderr[-200:]}"]
    found = json.loads(counted.read_text())
    row = {name: found[name] for name in ("form", "n_mutants", "accepted", "refused")}
    row |= {"first": int(reached["INITED"]), "last": int(reached["DONE"])}
    row["kept"] = sum(1 for _ in (folder / "corpus").iterdir())
    return row, found["faults"]


def _sorted_out(source: Source, folder: Path, database: str) -> tuple[list[bytes], list[bytes]]:
    """The inputs that were accepted, and the kept ones that are refused."""
    accepted = [file.read_bytes() for file in sorted((folder / "accepted").iterdir())]
    kept = [file.read_bytes() for file in sorted((folder / "corpus").iterdir())]
    count = Read(source.form)
    return accepted, [one for one in kept if not read_one(source, one, database, folder, count)]


def in_earnest(source: Source, data: bytes, database: str, folder: Path) -> list[str]:
    """What is wrong with an import of `data` and the same again: all is stored or nothing."""
    copy = str(shutil.copy(database, folder / "copy.db"))
    file = folder / source.file
    file.write_bytes(data)
    before = contents(copy)
    try:
        import_files(copy, [file], update=True)
    except (AvahazardError, OSError):
        return [] if contents(copy) == before else ["refused, and something is stored"]
    after = contents(copy)
    again = import_files(copy, [file], update=True).records
    changed = [
        kind
        for kind in ("paths", "profiles", "events", "speeds")
        if (counts := getattr(again, kind)).new or counts.updated
    ]
    faults = [f"the same again changes {', '.join(changed)}"] if changed else []
    return faults + ([] if contents(copy) == after else ["the same again stores something else"])


def evenly(items: Sequence[T], n: int) -> list[T]:
    """At most `n` of the items, from all over their row."""
    few = min(n, len(items))
    return [items[k * len(items) // few] for k in range(few)]
