"""Whole use cases on simulated regions of many paths."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from avahazard.engine import close_engine, set_engine
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.synth.making import make_dataset
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import init_database
from avahazard.workflow.hazard import hazard
from avahazard.workflow.requests import CalibrateRequest, HazardRequest
from benchmarks.measuring import Row, all_cores, alone, alternate, processor_seconds, seconds

PERIODS = (30.0, 100.0, 300.0)
BEFORE_S, COMPARE_BEFORE_S = 0.35, 486.0
"""What the version before took, in all or for a path."""
SOME = [f"P{k:02d}" for k in range(1, 21)]
"""Paths that a model is calibrated on, before it is applied to all."""
MOST_MEMORY, MOST_MB = 1.2, 4096
HAZARD = """
import json, sys, time
from avahazard.workflow.hazard import run_hazard
from avahazard.workflow.requests import HazardRequest
from benchmarks.measuring import peak_mb
run_hazard(sys.argv[1], "m", HazardRequest(return_periods=100, paths=sys.argv[2]))
begun = time.process_time()
run_hazard(sys.argv[1], "m", HazardRequest(return_periods=100))
print(json.dumps([time.process_time() - begun, peak_mb()]))
"""
# Both diagnoses have as many simulated datasets as there are at least: how many more a look takes
# until chance plainly does as well is itself chance.
EVENTS = """
import json, sys, time
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest
from benchmarks.measuring import peak_mb
calibrate(sys.argv[2], "m", CalibrateRequest(draws=100))
diagnose_model(sys.argv[2], "m", DiagnoseRequest())
times = []
for work in (
    lambda: calibrate(sys.argv[1], "m", CalibrateRequest()),
    lambda: diagnose_model(sys.argv[1], "m", DiagnoseRequest()),
):
    begun = time.process_time()
    work()
    times.append(time.process_time() - begun)
print(json.dumps([*times, peak_mb()]))
"""


def region(folder: str, n_paths: int, n_events: int) -> str:
    """A database with simulated records, nothing hidden."""
    database = str(Path(folder) / f"{n_paths}-{n_events}.db")
    init_database(database)
    with writing(database) as session:
        save_records(session, make_dataset(1, n_events, n_paths)[0])
    return database


def hazard_path(n_paths: int = 1000) -> Row:
    """`hazard` for three return periods: CPU seconds a path."""
    with tempfile.TemporaryDirectory() as folder:
        database = region(folder, n_paths, 10 * n_paths)
        calibrate(database, "m", CalibrateRequest(paths=SOME, draws=1000))
        hazard(database, "m", HazardRequest(return_periods=PERIODS, paths=SOME))  # compiles
        ours = (
            processor_seconds(lambda: hazard(database, "m", HazardRequest(return_periods=PERIODS)))
            / n_paths
        )
    note = (
        f"{n_paths} simulated paths of ten records and eight releases each, T = 30, 100, 300 "
        "years, the whole use case: loading, frequencies, runs, hazard, storing."
    )
    return BEFORE_S / ours, ours, BEFORE_S, note


def workers(n_paths: int = 300) -> Row:
    """The same by two processes against one; they are there already, and have compiled."""
    with all_cores(), tempfile.TemporaryDirectory() as folder:
        database = region(folder, n_paths, 10 * n_paths)
        calibrate(database, "m", CalibrateRequest(paths=SOME, draws=1000))

        def by(n: int) -> float:
            set_engine("processes", workers=n)
            hazard(
                database, "m", HazardRequest(return_periods=PERIODS, paths=SOME[:4])
            )  # starts them
            taken = seconds(lambda: hazard(database, "m", HazardRequest(return_periods=PERIODS)))
            close_engine()
            return taken

        found = alternate(lambda: by(2), lambda: by(1), 2)
    return (
        *found,
        f"{n_paths} simulated paths of ten records and eight releases each, at 30, 100, 300 years.",
    )


def compare_paths(n_paths: int = 1000) -> Row:
    """`compare` of a model on many paths of one event each: CPU seconds."""
    with tempfile.TemporaryDirectory() as folder:
        small = region(folder, 5, 20)
        calibrate(small, "m", CalibrateRequest(draws=200))
        compare(small, "m")  # compiles
        database = region(folder, n_paths, n_paths)
        calibrate(database, "m", CalibrateRequest(draws=1000))
        fits = []
        ours = processor_seconds(lambda: fits.append(compare(database, "m").held_out.n_fits))
    note = (
        f"{n_paths} simulated paths and events, the whole use case; held-out by path, in "
        f"{fits[0]} fits."
    )
    return COMPARE_BEFORE_S / ours, ours, COMPARE_BEFORE_S, note


def scaling(n_paths: int = 1000) -> Row:
    """`hazard` on ten times as many paths, in processes of their own: few, many, few."""
    found: dict[int, list[list[float]]] = {n_paths: [], 10 * n_paths: []}
    with tempfile.TemporaryDirectory() as folder:
        databases = {n: region(folder, n, 3 * n) for n in found}
        for n in (n_paths, 10 * n_paths, n_paths):
            if not found[n]:
                calibrate(databases[n], "m", CalibrateRequest(paths=SOME, draws=1000))
            found[n].append(alone(HAZARD, databases[n], SOME[0]))
    (few_s, few_mb), (many_s, many_mb) = (np.mean(each, axis=0) for each in found.values())
    note = (
        f"T = 100 years, {n_paths} paths and ten times as many, 3 records a path. Peak memory "
        f"{many_mb:.0f} against {few_mb:.0f} MB: {many_mb / few_mb:.2f} times (target: "
        f"{MOST_MEMORY:g})."
    )
    return float(many_s / few_s), float(many_s), float(few_s), note


def events(n_events: int = 2000) -> Row:
    """`calibrate` and `diagnose` on ten times as many events, in processes of their own."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for n in (n_events, 10 * n_events):
            small, database = region(folder, 4, 40 + len(found)), region(folder, n // 20, n)
            found.append(alone(EVENTS, database, small))
    few, many = found
    note = (
        f"{n_events} events and ten times as many: `calibrate` {many[0]:.0f} against {few[0]:.0f} "
        f"s, `diagnose` {many[1]:.0f} against {few[1]:.0f} s with 40 simulated datasets; 20 events "
        f"a path, nothing hidden. Peak memory {many[2]:.0f} MB (target: {MOST_MB})."
    )
    return sum(many[:2]) / sum(few[:2]), sum(many[:2]), sum(few[:2]), note
