"""`diagnose` on 13,392 records without profiles: seconds of a processor, on one core."""

from __future__ import annotations

import csv
import tempfile
from pathlib import Path

import numpy as np

from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import init_database
from avahazard.workflow.import_files import import_files
from avahazard.workflow.requests import CalibrateRequest
from benchmarks.measuring import Result, alone

SLIDES = Path(__file__).resolve().parents[3] / "shared/data/submarine-slides/events.csv"
TIMES, MOVED = 24, 0.1
"""Each slide stands so often, all but once with H, L and V moved by so much (sd of the log)."""
LIMIT_S, LIMIT_MB = 300.0, 1024
PROCESS = """
import json, sys, time
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import DiagnoseRequest
from benchmarks.measuring import peak_mb
diagnose_model(sys.argv[2], "m", DiagnoseRequest(worlds=39))
begun = time.process_time()
diagnose_model(sys.argv[1], "m", DiagnoseRequest())
print(json.dumps([time.process_time() - begun, peak_mb()]))
"""


def measure() -> Result:
    """CPU seconds of the whole use case, once compiled on the slides themselves."""
    with tempfile.TemporaryDirectory() as folder:
        small, large = _database(folder, 1), _database(folder, TIMES)
        ours, peak = alone(PROCESS, large, small)
    return Result(
        ours / LIMIT_S,
        ours,
        LIMIT_S,
        "CPU-s",
        1.0,
        True,
        "time of a diagnosis over five minutes",
        f"558 slides of the sea floor, {TIMES} times over, moved by {100 * MOVED:.0f} %: power "
        f"law, 199 worlds at most. Peak memory {peak:.0f} MB (wanted: {LIMIT_MB}). Theirs is the "
        "limit.",
    )


def _database(folder: str, times: int) -> str:
    """A database with the slides so many times, and a model of them."""
    rng = np.random.default_rng(1)
    with SLIDES.open(encoding="utf-8") as file:
        slides = list(csv.DictReader(file))
    table = Path(folder) / f"{times}.csv"
    with table.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, slides[0].keys())
        writer.writeheader()
        for time in range(times):
            for k, slide in enumerate(slides):
                moved = {"event_id": f"{time}-{k}"}
                for column in ("fall_height_m", "runout_length_m", "volume_m3"):
                    factor = np.exp(MOVED * rng.standard_normal()) if time else 1.0
                    moved[column] = str(float(slide[column]) * factor) if slide[column] else ""
                writer.writerow({**slide, **moved})
    database = str(Path(folder) / f"{times}.db")
    init_database(database)
    import_files(database, [table])
    calibrate(database, "m", CalibrateRequest(law="power"))
    return database
