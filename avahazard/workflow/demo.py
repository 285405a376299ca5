"""The main job on the demo data, from an empty database to a report; then a hidden effect."""

from importlib.resources import as_file, files
from pathlib import Path as FilePath
from typing import Any, cast

from avahazard.records.errors import AvahazardError
from avahazard.report.hazard_tables import write_hazard
from avahazard.report.html.content import path_view
from avahazard.report.plots import draw_paths
from avahazard.results.base import Report, silent, steps
from avahazard.results.files import Demo, HiddenEffect
from avahazard.synth.dataset import Settings
from avahazard.synth.effects import DEMO_EFFECT
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import write_records
from avahazard.workflow import requests
from avahazard.workflow.calibrate import add, calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import import_files, init_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.hazard import hazard
from avahazard.workflow.report import write_report
from avahazard.workflow.stored import records_of

MODEL, PAPERS_MODEL = "twin", "twin-gibbs"
DATABASE, BOUNDS, PICTURE = "twin.db", "twin-bounds.csv", "twin-bounds.png"
REPORT = "twin-report.html"
RETURN_PERIOD = 100.0
WEIGHTS = (7.0, 1.5, 8.0, 5.0, 3.5, 30.0)
"""Seconds of the calibrations, the bounds, the comparison, the report, and the hidden effect."""


def run_demo(folder: FilePath, report: Report = silent) -> Demo:
    """Import the twin into a new database in `folder`, calibrate it, give design runouts, report.

    Then the loop finds a hidden effect in a synthetic dataset. A second run makes its files anew,
    and leaves others alone. Raises `AvahazardError` where the folder cannot be made or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for file in (DATABASE, HIDDEN_DATABASE):
            for suffix in ("", "-wal", "-shm"):
                (folder / f"{file}{suffix}").unlink(missing_ok=True)
    except OSError as error:
        raise AvahazardError(
            f"The folder {folder} cannot be used: {error.strerror}.",
            "Name another one: avahazard demo --folder FOLDER.",
        ) from error
    tell = steps(report, WEIGHTS)
    name = str(folder / DATABASE)
    init_database(name)
    with as_file(files("avahazard.data")) as data:
        sources = [data / file for file in ("paths.csv", "profiles.csv", "events.csv")]
        import_files(name, sources)
    model = calibrate(name, MODEL, requests.CalibrateRequest(), tell[0])
    gibbs = calibrate(name, PAPERS_MODEL, requests.CalibrateRequest(method="gibbs"), tell[1])
    bounds = hazard(name, MODEL, requests.HazardRequest(return_periods=[RETURN_PERIOD]), tell[2])
    write_hazard(folder / BOUNDS, bounds.rows)
    records = records_of(name)
    title = f"100-year design runout on the twin of Ancey's (2005) seven paths, model “{MODEL}”"
    views = [path_view(records, row.path_id, rows=[row]) for row in bounds.rows]
    draw_paths(folder / PICTURE, title, views, drag=False)
    compare(name, MODEL, report=tell[3])
    write_report(name, MODEL, folder / REPORT, requests.ReportRequest(), tell[4])
    loop = find_hidden(folder, tell[5])
    written = [str(folder / file) for file in (DATABASE, BOUNDS, PICTURE, REPORT)]
    return Demo(
        database=name,
        files=(*written, *map(str, sources)),
        twin="The data are a twin: made up from the facts that Ancey (2005) prints.",
        model=model,
        gibbs=gibbs,
        hazard=bounds.rows,
        loop=loop,
        notes=(*model.notes, *gibbs.notes, *bounds.notes),
    )


STRENGTH = 2.0
"""Strong enough that few events show it, and quickly."""
SEED, N_EVENTS, N_PATHS = 0, 120, 6

DATASET, HIDDEN_DATABASE, HIDDEN_REPORT = "synthetic-dataset", "hidden.db", "hidden-report.html"
BASE, CHILD = "base", "child"
LOOP_WEIGHTS = (3.5, 2.5, 8.5, 7.0, 5.0, 4.0)
"""Seconds of calibration, comparison, diagnosis, child, its design runouts, and report."""


def find_hidden(folder: FilePath, report: Report) -> HiddenEffect:
    """Make a synthetic dataset with a hidden effect in `folder`, and let the loop find it.

    What is added is what the diagnosis names, and nothing where it names no single effect. Files of
    an earlier run must be gone, but for the records.
    """
    tell = steps(report, LOOP_WEIGHTS)
    records, truth = make_dataset(SEED, N_EVENTS, N_PATHS, {DEMO_EFFECT: STRENGTH}, Settings())
    (folder / DATASET).mkdir(exist_ok=True)
    sources = write_records(folder / DATASET, records)
    database = str(folder / HIDDEN_DATABASE)
    init_database(database)
    import_files(database, sources)
    model = calibrate(database, BASE, requests.CalibrateRequest(), tell[0])
    compared = compare(database, BASE, report=tell[1])
    diagnosis = diagnose_model(database, BASE, requests.DiagnoseRequest(), tell[2])
    child, last = None, BASE
    if diagnosis.verdict == "missing-effect":
        child, last = add(database, BASE, diagnosis.missing, CHILD, report=tell[3]), CHILD
    bounds = hazard(database, last, requests.HazardRequest(), tell[4])
    page = folder / HIDDEN_REPORT
    write_report(database, last, page, requests.ReportRequest(), tell[5])
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
