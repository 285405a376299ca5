"""Mutants of every form in front of what reads it: accepted, or refused by a message."""

from __future__ import annotations

import signal
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from avahazard.records.errors import AvahazardError
from benchmarks.trust.sources import Source

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


def read_mutants(
    source: Source, n_mutants: int, seed: int, database: str, folder: Path, n_kept: int = 0
) -> Read:
    """Read mutants of `source`: what raises anything but a message, or hangs, is at fault."""
    found = Read(source.form)
    for mutant in mutants_of(source, n_mutants, seed):
        if read_one(source, mutant, database, folder, found) and len(found.kept) < n_kept:
            found.kept.append(mutant)
    return found


def read_one(source: Source, mutant: bytes, database: str, folder: Path, found: Read) -> bool:
    """Read one mutant, count in `found` what came of it, and return whether it was accepted."""
    file = folder / source.file
    file.write_bytes(mutant)
    k = found.n_mutants
    found.n_mutants += 1
    try:
        with warnings.catch_warnings(), _at_most(MOST_SECONDS):
            warnings.simplefilter("ignore")
            source.read(database, file)
    except (AvahazardError, OSError) as error:
        found.refused += 1
        if not str(error).strip():
            found.faults.append(f"mutant {k}: a message without words")
        return False
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        found.faults.append(
            f"mutant {k}: {error!r:.200} ({Path(place.filename).name}:{place.lineno})"
        )
        return False
    found.accepted += 1
    return True


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
