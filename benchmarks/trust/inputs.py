"""Mutants of the files of every form, read: accepted, or refused with a message."""

from __future__ import annotations

import multiprocessing
import shutil
import signal
import traceback
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from avahazard.records.errors import AvahazardError
from benchmarks.study import Line, bullets, table
from benchmarks.trust.answers import Chained, chain
from benchmarks.trust.commands import write_databases
from benchmarks.trust.sources import FORMS, Source, sources

MOST_SECONDS = 60


@dataclass(slots=True)
class Read:
    """What came of the mutants of one form; `kept` are some that were accepted."""

    form: str
    n_mutants: int = 0
    accepted: int = 0
    refused: int = 0
    faults: list[str] = field(default_factory=list)
    kept: list[bytes] = field(default_factory=list)


def mutants(given: Any, folder: Path) -> Line:
    """Mutants of every form before the readers, then the whole chain on some that were accepted."""
    database, empty = write_databases(folder)
    forms = sources(folder)
    each = given.mutants // len(forms)
    n_chained = sum(source.chain for source in forms)
    rows, faults, ends = [], [], []
    for source in forms:
        n_kept = given.chains // n_chained if source.chain else 0
        read = _read_apart(source.form, each, given.seed, database, folder, n_kept)
        print(f"{read.form}: {read.n_mutants}, {read.accepted} accepted {read.faults[:3]}")
        faults += [f"{read.form}: {fault}" for fault in read.faults]
        rows.append({k: getattr(read, k) for k in ("form", "n_mutants", "accepted", "refused")})
        ends += [_chained(source, k, one, empty, folder) for k, one in enumerate(read.kept)]
    return {
        "rows": rows,
        "chains": len(ends),
        "done": sum(one.done for one in ends),
        "refused": sum(one.refused for one in ends),
        "faults": faults,
        "chain_faults": [f"{one.name}: {fault}" for one in ends for fault in one.faults],
    }


def page(found: Line) -> str:
    """A row for each form."""
    names = ("form", "n_mutants", "accepted", "refused")
    rows = [[row[name] for name in names] for row in found["rows"]]
    return (
        f"{sum(row['n_mutants'] for row in found['rows']):,} mutants.\n\n"
        + table(("form", "mutants", "accepted", "refused"), rows)
        + f"\n\n{bullets(found['faults'], 'No traceback, and no reader that hung.')}\n\n"
        f"{found['chains']} of the accepted went through the chain: {found['done']:,} commands "
        f"succeeded, {found['refused']:,} were refused with a message.\n\n"
        + bullets(found["chain_faults"], "No fault.")
    )


def _read_apart(form: str, n: int, seed: int, database: str, folder: Path, n_kept: int) -> Read:
    """Read mutants in a process of their own: a library that dies of one takes only that along."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        try:
            return pool.submit(_read, form, n, seed, database, folder, n_kept).result()
        except BrokenProcessPool:
            return Read(form, n, faults=["the process died"])


def _read(form: str, n: int, seed: int, database: str, folder: Path, n_kept: int) -> Read:
    source = next(one for one in sources(folder) if one.form == form)
    inside = folder / "mutant"
    inside.mkdir(exist_ok=True)
    return read_mutants(source, n, seed, database, inside, n_kept)


def _chained(source: Source, k: int, mutant: bytes, empty: str, folder: Path) -> Chained:
    """The whole chain on the mutant with the other files of its dataset."""
    inside = folder / "chain"
    shutil.rmtree(inside, ignore_errors=True)
    inside.mkdir()
    database = str(shutil.copy(empty, inside / "avahazard.db"))
    if source.form not in {"workbook", "events by H, L"}:
        for form in FORMS:
            shutil.copy(folder / "world" / f"{form}.csv", inside)
    (inside / source.file).write_bytes(mutant)
    files = sorted(f.name for f in inside.iterdir() if f.suffix in (".csv", ".xlsx"))
    found = chain(f"{source.form} {k}", database, files, inside)
    print(found)
    return found


def read_mutants(
    source: Source, n_mutants: int, seed: int, database: str, folder: Path, n_kept: int = 0
) -> Read:
    """Read mutants of `source`: what raises anything but a message, or hangs, is at fault."""
    found = Read(source.form)
    file = folder / source.file
    for mutant in mutants_of(source, n_mutants, seed):
        file.write_bytes(mutant)
        k, found.n_mutants = found.n_mutants, found.n_mutants + 1
        try:
            with warnings.catch_warnings(), _at_most(MOST_SECONDS):
                warnings.simplefilter("ignore")
                source.read(database, file)
        except (AvahazardError, OSError) as error:
            found.refused += 1
            if not str(error).strip():
                found.faults.append(f"mutant {k}: a message without words")
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{Path(place.filename).name}:{place.lineno}"
            found.faults.append(f"mutant {k}: {error!r:.200} ({where})")
        else:
            found.accepted += 1
            if len(found.kept) < n_kept:
                found.kept.append(mutant)
    return found


def mutants_of(source: Source, n_mutants: int, seed: int) -> Iterator[bytes]:
    """The same mutants for the same seed, each other than the right file."""
    for k in range(n_mutants):
        rng = np.random.default_rng([seed, k, *source.form.encode()])
        mutant = source.mutate(source.content, rng)
        if mutant != source.content:
            yield mutant


@contextmanager
def _at_most(seconds: int) -> Iterator[None]:
    """Raise `RuntimeError` after that many seconds: a reader that hangs is at fault."""

    def stop(*_: object) -> NoReturn:
        raise RuntimeError(f"it takes over {seconds} s")

    signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
