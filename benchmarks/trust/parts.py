"""The parts of `make trust`: each returns what it counted, as plain values for the page."""

from __future__ import annotations

import multiprocessing
import shutil
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.store import upkeep
from avahazard.workflow.import_files import import_files
from benchmarks.trust.chain import Chained, chain
from benchmarks.trust.degenerate import SETS, run_set
from benchmarks.trust.disks import can_mount, disturb
from benchmarks.trust.jobs import JOBS, write_records
from benchmarks.trust.kills import kill_jobs
from benchmarks.trust.places import places
from benchmarks.trust.power import can_cut, cut_power
from benchmarks.trust.readers import Read, read_mutants
from benchmarks.trust.sources import FORMS, Source, sources
from benchmarks.trust.upgrades import earlier_revisions, upgrade_all
from benchmarks.trust.users import large_imports, mix

Tell = Callable[[str], None]
N_USERS = 6
LONGEST_FAULT = 300


@dataclass(frozen=True, slots=True)
class Amounts:
    """How much of each part is done."""

    kills: int = 300
    cuts: int = 500
    sizes: int = 4
    seconds: float = 60.0
    rows: int = 50_000
    mutants: int = 20_000
    chains: int = 200
    seed: int = 15


def kills(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """kill -9 over all writing commands, shared among the databases."""
    write_records(folder)
    found = []
    mine = places()
    for place in mine:
        rng = np.random.default_rng([amounts.seed, len(place.name)])
        inside = folder / place.name
        inside.mkdir()
        for name in ("world", "changed"):
            (inside / name).symlink_to(folder / name)
        shutil.copy(folder / "avahazard.toml", inside)
        for one in kill_jobs(JOBS, place, amounts.kills // len(mine), rng, inside):
            tell(f"{place.name}: {one.job} after {one.moment:.1f} s, {one.stood} {one.faults}")
            found.append(one)
    rows = []
    for place in mine:
        for job in JOBS:
            there = [one for one in found if (one.place, one.job) == (place.name, job.name)]
            if there:
                stood = Counter(one.stood for one in there)
                rows.append({"place": place.name, "job": job.name, "kills": len(there), **stood})
    faults = [f"{one.place}, {one.job}: {fault}" for one in found for fault in one.faults]
    return {"rows": rows, "faults": _cut(faults)}


def power(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Power cuts; with weaker syncs too, which shows that the study sees losses."""
    if not can_cut():
        return {"skipped": "no gcc here to build what logs the writes"}
    rows = []
    for k, (holder, synchronous) in enumerate(
        (("alone", "FULL"), ("held", "FULL"), ("held", "NORMAL"), ("alone", "OFF"))
    ):
        inside = folder / str(k)
        inside.mkdir()
        rng = np.random.default_rng([amounts.seed, k])
        n = amounts.cuts if synchronous == "FULL" else min(amounts.cuts, 100)
        rows.append(asdict(cut_power(inside, n, rng, holder=holder, synchronous=synchronous)))
        tell(str(rows[-1]))
    return {"rows": rows}


def disks(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Full disks, read-only and vanishing folders, clocks that jump."""
    write_records(folder)
    found = []
    for one in disturb(JOBS, amounts.sizes, np.random.default_rng(amounts.seed), folder):
        tell(f"{one.fault}: {one.job}, {'told' if one.told else 'done'} {one.faults}")
        found.append(one)
    kinds = list(dict.fromkeys(one.fault for one in found))
    rows = [
        {
            "fault": kind,
            "commands": sum(one.fault == kind for one in found),
            "told": sum(one.fault == kind and one.told for one in found),
        }
        for kind in kinds
    ]
    faults = [f"{one.fault}, {one.job}: {fault}" for one in found for fault in one.faults]
    return {"rows": rows, "mounted": can_mount(), "faults": _cut(faults)}


def users(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Eight users for a while, and six large imports at once."""
    rows = []
    for place in places():
        for what in ("mix", "large"):
            inside = folder / f"{place.name}-{what}"
            inside.mkdir()
            database = place.new(inside)
            upkeep.create(database)
            done = (
                mix(place.name, database, inside, amounts.seconds)
                if what == "mix"
                else large_imports(place.name, database, inside, N_USERS, amounts.rows)
            )
            place.drop(database)
            tell(str(done))
            rows.append(asdict(done))
    return {"rows": rows, "seconds": amounts.seconds, "rows_of_import": amounts.rows}


def upgrades(_amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Databases of every earlier revision."""
    write_records(folder)
    rows = []
    for place in places():
        inside = folder / place.name
        inside.mkdir()
        for name in ("world", "changed"):
            (inside / name).symlink_to(folder / name)
        for one in upgrade_all(place, inside, earlier_revisions()):
            tell(str(one))
            rows.append(asdict(one))
    return {"rows": rows}


def mutants(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Mutants of every form before the readers, then the whole chain on some that were accepted."""
    write_records(folder)
    database, empty = str(folder / "records.db"), str(folder / "empty.db")
    upkeep.create(empty)
    shutil.copy(empty, database)
    import_files(database, [folder / "world"])
    forms = sources(folder)
    each = amounts.mutants // len(forms)
    n_chained = sum(source.chain for source in forms)
    rows, faults, chained = [], [], []
    for source in forms:
        n_kept = amounts.chains // n_chained if source.chain else 0
        read = _read_apart(source.form, each, amounts.seed, database, folder, n_kept)
        tell(f"{read.form}: {read.n_mutants}, {read.accepted} accepted {read.faults[:3]}")
        row = asdict(read)
        faults += [f"{read.form}: {fault}" for fault in row.pop("faults")]
        del row["kept"]
        rows.append(row)
        for k, mutant in enumerate(read.kept):
            chained.append(_chained(source, k, mutant, empty, folder))
            tell(str(chained[-1]))
    ends = [f"{one.name}: {fault}" for one in chained for fault in one.faults]
    return {
        "rows": rows,
        "chains": len(chained),
        "done": sum(one.done for one in chained),
        "refused": sum(one.refused for one in chained),
        "faults": _cut(faults),
        "chain_faults": _cut(ends),
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
    return {"rows": rows, "faults": _cut(faults)}


PARTS: dict[str, Callable[[Amounts, Path, Tell], dict[str, Any]]] = {
    "kills": kills,
    "power": power,
    "disks": disks,
    "users": users,
    "upgrades": upgrades,
    "mutants": mutants,
    "degenerate": degenerate,
}


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


def _chained(source: Source, k: int, mutant: bytes, empty: str, folder: Path) -> Chained:
    """The mutant with the other files of its world."""
    inside = folder / "chain"
    shutil.rmtree(inside, ignore_errors=True)
    inside.mkdir()
    database = str(shutil.copy(empty, inside / "avahazard.db"))
    if source.form not in {"workbook", "events by H, L"}:
        for form in FORMS:
            shutil.copy(folder / "world" / f"{form}.csv", inside)
    (inside / source.file).write_bytes(mutant)
    files = sorted(f.name for f in inside.iterdir() if f.suffix in (".csv", ".xlsx"))
    return chain(f"{source.form} {k}", database, files, inside)


def _cut(faults: list[str]) -> list[str]:
    return [fault[:LONGEST_FAULT] for fault in dict.fromkeys(faults)]
