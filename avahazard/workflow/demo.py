"""The main job on the demo data, from an empty database to a report; then a hidden effect."""

from __future__ import annotations

from importlib.resources import as_file, files
from pathlib import Path as FilePath

from avahazard.records.errors import AvahazardError
from avahazard.report.bounds_pictures import draw_hazard
from avahazard.report.hazard_tables import write_hazard
from avahazard.results.base import Report, silent
from avahazard.results.made import Demo
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow import demo_loop
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import init_database
from avahazard.workflow.hazard import hazard
from avahazard.workflow.import_files import import_files
from avahazard.workflow.report import write_report
from avahazard.workflow.requests import CalibrateRequest, HazardRequest, ReportRequest
from avahazard.workflow.steps import steps

MODEL, PAPERS_MODEL = "twin", "twin-gibbs"
DATABASE, BOUNDS, PICTURE = "twin.db", "twin-bounds.csv", "twin-bounds.png"
REPORT = "twin-report.html"
RETURN_PERIOD = 100.0
WEIGHTS = (7.0, 1.5, 8.0, 5.0, 3.5, 30.0)
"""Seconds of the calibrations, the bounds, the comparison, the report, and the hidden effect."""


def run_demo(
    folder: FilePath,
    report: Report = silent,
) -> Demo:
    """Import the twin into a new database in `folder`, calibrate it, give design runouts, report.

    `model` is calibrated by the marginal method, `gibbs` by the paper's sampler. Then the loop
    finds a hidden effect in a made world (`demo_loop`). A second run makes the files anew and
    leaves others alone.

    Raises:
        AvahazardError: the folder cannot be made or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        database = folder / DATABASE
        for file in (DATABASE, demo_loop.DATABASE):
            for suffix in ("", "-wal", "-shm"):
                (folder / f"{file}{suffix}").unlink(missing_ok=True)
    except OSError as error:
        raise AvahazardError(
            f"The folder {folder} cannot be used: {error.strerror}.",
            "Name another one: avahazard demo --folder FOLDER.",
        ) from error
    tell = steps(report, WEIGHTS)
    name = str(database)
    init_database(name)
    with as_file(files("avahazard.data")) as data:
        sources = [data / file for file in ("paths.csv", "profiles.csv", "events.csv")]
        import_files(name, sources)
    model = calibrate(name, MODEL, CalibrateRequest(), tell[0])
    gibbs = calibrate(name, PAPERS_MODEL, CalibrateRequest(method="gibbs"), tell[1])
    bounds = hazard(name, MODEL, HazardRequest(return_periods=[RETURN_PERIOD]), tell[2])
    write_hazard(folder / BOUNDS, bounds.rows)
    with reading(name) as session:
        records = load_records(session)
    title = f"100-year design runout on the twin of Ancey's (2005) seven paths, model “{MODEL}”"
    draw_hazard(folder / PICTURE, title, records, bounds.rows)
    compare(name, MODEL, report=tell[3])
    write_report(name, MODEL, folder / REPORT, ReportRequest(), tell[4])
    loop = demo_loop.find_hidden(folder, tell[5])
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
