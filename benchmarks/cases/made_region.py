"""Made regions in databases, for the rows that run use cases whole."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.synth.making import make_world
from avahazard.workflow.database import init_database


def region(folder: str, n_paths: int, n_events: int, seed: int = 1) -> str:
    """A database with a made world, nothing hidden."""
    database = str(Path(folder) / f"{n_paths}-{n_events}.db")
    init_database(database)
    records, _ = make_world(seed, n_events, n_paths)
    with writing(database) as session:
        save_records(session, records)
    return database


def cpu_seconds(work: Callable[[], object]) -> float:
    """Seconds of all processors that a call takes."""
    start = time.process_time()
    work()
    return time.process_time() - start
