"""Mutants of files, and records that tell next to nothing, counted."""

from __future__ import annotations

import multiprocessing
import shutil
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict
from pathlib import Path
from typing import Any

from avahazard.store import upkeep
from benchmarks.trust.amounts import Amounts, Tell, cut
from benchmarks.trust.chain import STEPS, Chained, Steps, chain
from benchmarks.trust.degenerate import SETS, run_set
from benchmarks.trust.jobs import write_databases
from benchmarks.trust.readers import Read, read_mutants
from benchmarks.trust.sources import FORMS, Source, sources


def mutants(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Mutants of every form before the readers, then the whole chain on some that were accepted."""
    database, empty = write_databases(folder)
    forms = sources(folder)
    each = amounts.mutants // len(forms)
    n_chained = sum(source.chain for source in forms)
    rows, faults, ends = [], [], []
    for source in forms:
        n_kept = amounts.chains // n_chained if source.chain else 0
        read = _read_apart(source.form, each, amounts.seed, database, folder, n_kept)
        tell(f"{read.form}: {read.n_mutants}, {read.accepted} accepted {read.faults[:3]}")
        row = asdict(read)
        faults += [f"{read.form}: {fault}" for fault in row.pop("faults")]
        del row["kept"]
        rows.append(row)
        for k, mutant in enumerate(read.kept):
            ends.append(chained(source, k, mutant, empty, folder))
            tell(str(ends[-1]))
    return {
        "rows": rows,
        "chains": len(ends),
        "done": sum(one.done for one in ends),
        "refused": sum(one.refused for one in ends),
        "faults": cut(faults),
        "chain_faults": cut([f"{one.name}: {fault}" for one in ends for fault in one.faults]),
    }


def degenerate(_amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Every command on records that tell next to nothing."""
    rows, faults = [], []
    for name in SETS:
        inside = folder / name.replace(" ", "-")
        inside.mkdir()
        database = str(inside / "avahazard.db")
        upkeep.create(database)
        found = run_set(name, database, inside)
        tell(str(found))
        faults += [f"{name}: {fault}" for fault in found.faults]
        rows.append({"set": name, "done": found.done, "refused": found.refused})
    return {"rows": rows, "faults": cut(faults)}


def _read_apart(form: str, n: int, seed: int, database: str, folder: Path, n_kept: int) -> Read:
    """Read mutants in a process of their own: a library that dies of one takes only that along."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        try:
            return pool.submit(_read, form, n, seed, database, str(folder), n_kept).result()
        except BrokenProcessPool:
            return Read(form, n, faults=["the process died"])


def _read(form: str, n: int, seed: int, database: str, folder: str, n_kept: int) -> Read:
    source = next(one for one in sources(Path(folder)) if one.form == form)
    inside = Path(folder) / "mutant"
    inside.mkdir(exist_ok=True)
    return read_mutants(source, n, seed, database, inside, n_kept)


def chained(
    source: Source, k: int, mutant: bytes, empty: str, folder: Path, steps: Steps = STEPS
) -> Chained:
    """The whole chain on the mutant with the other files of its world."""
    inside = folder / "chain"
    shutil.rmtree(inside, ignore_errors=True)
    inside.mkdir()
    database = str(shutil.copy(empty, inside / "avahazard.db"))
    if source.form not in {"workbook", "events by H, L"}:
        for form in FORMS:
            shutil.copy(folder / "world" / f"{form}.csv", inside)
    (inside / source.file).write_bytes(mutant)
    files = sorted(f.name for f in inside.iterdir() if f.suffix in (".csv", ".xlsx"))
    return chain(f"{source.form} {k}", database, files, inside, steps)
