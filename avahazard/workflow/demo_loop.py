"""The loop on a made world: calibrated, compared, diagnosed, and what was named added."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Any, cast

from avahazard.results.base import Report
from avahazard.results.made import HiddenEffect
from avahazard.synth.effects import DEMO_EFFECT
from avahazard.synth.making import make_world
from avahazard.synth.settings import Settings
from avahazard.synth.writing import write_records
from avahazard.workflow.add import add
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import init_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.hazard import hazard
from avahazard.workflow.import_files import import_files
from avahazard.workflow.report import write_report
from avahazard.workflow.requests import (
    CalibrateRequest,
    DiagnoseRequest,
    HazardRequest,
    ReportRequest,
)
from avahazard.workflow.steps import steps

STRENGTH = 2.0
"""Strong enough that few events and few worlds show it, and quickly."""
SEED, N_EVENTS, N_PATHS = 0, 120, 6

WORLD, DATABASE, REPORT = "hidden-world", "hidden.db", "hidden-report.html"
MODEL, CHILD = "base", "child"
N_WORLDS = 39
WEIGHTS = (3.5, 2.5, 8.5, 7.0, 5.0, 4.0)
"""Seconds of calibration, comparison, diagnosis, child, its design runouts, and report."""


def find_hidden(folder: FilePath, report: Report) -> HiddenEffect:
    """Make a world with a hidden effect in `folder`, and let the loop find it.

    What is added is what the diagnosis names, and nothing where it names no single effect. The
    report is that of the last model. Files of an earlier run must be gone, but for the records.
    """
    tell = steps(report, WEIGHTS)
    records, truth = make_world(SEED, N_EVENTS, N_PATHS, {DEMO_EFFECT: STRENGTH}, Settings())
    world = folder / WORLD
    world.mkdir(exist_ok=True)
    sources = write_records(world, records)
    database = str(folder / DATABASE)
    init_database(database)
    import_files(database, sources)
    model = calibrate(database, MODEL, CalibrateRequest(), tell[0])
    compared = compare(database, MODEL, report=tell[1])
    diagnosis = diagnose_model(database, MODEL, DiagnoseRequest(worlds=N_WORLDS), tell[2])
    child, last = None, MODEL
    if diagnosis.verdict == "missing-effect":
        child, last = add(database, MODEL, diagnosis.missing, CHILD, report=tell[3]), CHILD
    bounds = hazard(database, last, HazardRequest(), tell[4])
    page = folder / REPORT
    write_report(database, last, page, ReportRequest(), tell[5])
    return HiddenEffect(
        database=database,
        files=(database, str(page), *map(str, sources)),
        report=str(page),
        hidden=cast(dict[str, Any], truth["effects"]),
        n_paths=len(records.paths),
        model=model,
        coordinate=compared.coordinate,
        held_out=compared.held_out,
        diagnosis=diagnosis,
        child=child,
        hazard=bounds.rows,
        notes=(*model.notes, *(child.notes if child else ()), *bounds.notes),
    )
