"""A small database with everything that a report can show."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.records.collection import TerrainCrop
from avahazard.store import results, upkeep
from avahazard.store.records import save_terrain
from avahazard.store.session import writing
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import write_records
from avahazard.workflow.calibrate import add, calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import import_files
from avahazard.workflow.hazard import hazard, zones
from avahazard.workflow.requests import CalibrateRequest, HazardRequest, ZonesRequest
from tests.few_draws import few_draws

DATA = Path(__file__).resolve().parents[3] / "data"
NAMES = {
    "scey": "Scey</script><script>window.evil = 1</script>",
    "saugy": "<img src=x onerror='window.evil = 1'>",
    "nants": "Nants & <b>Co</b> %{x} $\\\\mu$",
}
"""Names that are harmless only where they are treated as words."""
EVENT = "</script><script>window.evil = 1</script> 12"
EAST, NORTH, CRS = 250_000.0, 380_000.0, "EPSG:31287"


def make_report_database(folder: Path) -> str:
    """Three paths: `scey` with a map and its ground, `nants` with degrees, `saugy` with neither."""
    database = str(folder / "report.db")
    _write(folder / "paths.csv", _rows("paths.csv"), _path)
    _write(folder / "profiles.csv", _rows("profiles.csv"), _point)
    _write(folder / "events.csv", _rows("events.csv"), _event)
    upkeep.create(database)
    import_files(database, [folder / f"{name}.csv" for name in ("paths", "profiles", "events")])
    calibrate(database, "m", CalibrateRequest(chains=2, draws=100))
    with few_draws():
        compare(database, "m")
    hazard(
        database,
        "m",
        HazardRequest(return_periods=[30.0, 300.0], paths=["scey", "nants"], draws=1000),
    )
    zones(database, "m", ZonesRequest(no_drag=True, paths=["scey"]))
    with writing(database) as session:
        results.save_result(session, results.DIAGNOSIS, "m", DIAGNOSIS)
        save_terrain(session, [_ground()])
    return database


def make_loop_database(folder: Path) -> str:
    """A synthetic dataset in which snow type rules: `base` does not know it, `child` does."""
    database = str(folder / "loop.db")
    records, _ = make_dataset(3, 60, 3, {"snow-type": 2.0})
    upkeep.create(database)
    import_files(database, [*write_records(folder, records)])
    calibrate(database, "base", CalibrateRequest(chains=2, draws=100))
    with few_draws():
        compare(database, "base")
    with writing(database) as session:
        found = {**DIAGNOSIS, "model": "base", "verdict": "missing-effect",
                 "missing": ["snow-type"], "where": ["P01 has snow."]}  # fmt: skip
        best = {**DIAGNOSIS["candidates"][0], "effect": "snow-type", "p_value": 1 / 40}
        results.save_result(session, results.DIAGNOSIS, "base", {**found, "candidates": [best]})
    with few_draws():
        add(database, "base", ["snow-type"], "child")
    hazard(database, "child", HazardRequest(return_periods=[100.0], draws=300))
    return database


def _rows(name: str) -> list[dict[str, str]]:
    with (DATA / name).open(encoding="utf-8", newline="") as handle:
        return [row for row in csv.DictReader(handle) if row["path_id"] in NAMES]


def _write(file: Path, rows: list[dict[str, str]], change: Any) -> None:
    rows = [change(k, row) for k, row in enumerate(rows)]
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with file.open("w", encoding="utf-8", newline="") as handle:
        writer = csv.DictWriter(handle, columns, restval="")
        writer.writeheader()
        writer.writerows(rows)


def _path(_: int, row: dict[str, str]) -> dict[str, str]:
    return {**row, "name": NAMES[row["path_id"]]}


def _point(_: int, row: dict[str, str]) -> dict[str, str]:
    x = float(row["x_m"])
    if row["path_id"] == "scey":
        return {**row, "easting_m": f"{EAST + 0.6 * x:.1f}", "northing_m": f"{NORTH - 0.8 * x:.1f}",
                "crs": CRS}  # fmt: skip
    if row["path_id"] == "nants":
        return {**row, "lon": f"{6.6 + x * 1e-5:.6f}", "lat": f"{45.6 - x * 5e-6:.6f}"}
    return row


def _event(k: int, row: dict[str, str]) -> dict[str, str]:
    return {**row, "event_id": EVENT} if k == 12 else row


def _ground() -> TerrainCrop:
    """A slope with a dale, 60 cells of 60 m each way; one cell is not known."""
    row, column = np.mgrid[0:60, 0:60]
    ground = (2000.0 - 15.0 * row + 0.5 * (column - 25.0) ** 2).astype(np.float32)
    ground[3, 3] = np.nan
    return TerrainCrop("scey", CRS, EAST - 500.0, NORTH + 300.0, 60.0, ground)


DIAGNOSIS: dict[str, Any] = {
    "model": "m",
    "verdict": "ambiguous",
    "missing": ["season", "covariate:<b>wind</b>"],
    "candidates": [
        {
            "effect": effect,
            "gain": gain,
            "evidence_gain": gain,
            "held_out_gain": 1.0,
            "p_value": p,
            "screened_gain": gain,
            "chance_gain": 2.5,
            "p_value_alone": p,
            "error_before_m": 60.0,
            "error_after_m": None if gain < 1 else 55.0,
            "parameters": {},
            "physics": "Words on <physics>.",
            "confounded_with": [],
        }
        for effect, gain, p in (
            ("season", 9.0, 0.005),
            ("covariate:<b>wind</b>", 8.5, 0.01),
            ("path-effect", -0.1, 1.0),
        )
    ],
    "groups": [{"effect": "path-effect", "gain": 0.1, "p_value": 0.7, "spread": 0.03}],
    "detectable_m": 25.0,
    "detectable_log_friction": 0.05,
    "measure_next": [
        {"measurement": "speeds on 5 events", "expected_gain": 6.0, "field_days": 10.0}
    ],
    "still_needed": {},
    "heavy_tails": False,
    "suspect_events": [],
    "n_worlds": 39,
    "seed": 0,
}
