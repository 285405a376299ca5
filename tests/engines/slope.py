"""A slope with its terrain, line and records, and a program in the place of AvaFrame's Python."""

from __future__ import annotations

import csv
import inspect
import os
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyogrio
import rasterio
import shapely

CELL_M, WEST, NORTH, LENGTH_M = 10.0, 380_000.0, 400_600.0, 1880.0
LAW = 0.42, 4e-6
"""Friction of small avalanches, and how it falls by volume (1/m3)."""


def stop_m(friction: float, volume_m3: float) -> float:
    """Where the program in AvaFrame's place lets avalanches stop, along the line."""
    return float(np.clip(700.0 / friction * (volume_m3 / 1e4) ** 0.05 - 200.0, 100.0, LENGTH_M))


PROGRAM = '''#!{python}
"""Stands for the Python of AvaFrame: flows as wide as 100 m that stop where a formula says.

It starts often, so it reads the shapes by itself: the import of pyogrio takes longer than the rest.
"""
import configparser, struct, sys
from pathlib import Path
if sys.argv[1] == "-c":
    print("{version}")
    raise SystemExit
import numpy as np, rasterio, shapely

WEST, LENGTH_M = {west}, {length}

{stop}

def points_of(file):
    data = file.read_bytes()[108:]
    n_parts, n_points = struct.unpack("<2i", data[36:44])
    return np.frombuffer(data, "<f8", 2 * n_points, 44 + 4 * n_parts).reshape(n_points, 2)

folder = Path(sys.argv[3])
cfg = configparser.ConfigParser()
cfg.read(folder / "Inputs/CFGs/com1DFACfg.ini")
general = cfg["GENERAL"]
mu = float(general.get("mucoulomb", general.get("muvoellmy")))
release = shapely.Polygon(points_of(folder / "Inputs/REL/release.shp"))
slope = 1.6 * np.exp((WEST - release.centroid.x) / 500.0)
area = release.area * np.hypot(1.0, slope)
line = shapely.LineString(points_of(folder / "Inputs/LINES/path_aimec.shp"))
with rasterio.open(folder / "Inputs/dem.tif") as dem:
    profile = dem.profile
    column, row = np.meshgrid(np.arange(dem.width), np.arange(dem.height))
    x, y = rasterio.transform.xy(dem.transform, row.ravel(), column.ravel())
points = shapely.points(x, y)
along = shapely.line_locate_point(line, points)
stop = stop_m(mu, float(general["relTh"]) * area)
there = (along > 0.0) & (along <= stop) & (shapely.distance(points, line) < 50.0)
peak = np.where(there, 2.0 + 0.2 * (stop - along), 0.0).reshape(row.shape)
target = folder / "Outputs/com1DFA/peakFiles"
target.mkdir(parents=True)
with rasterio.open(target / "release_ppr.tif", "w", **profile) as out:
    out.write(peak.astype("float32"), 1)
'''


def write_program(folder: Path, version: str = "2.1") -> Path:
    """Write the program in AvaFrame's place."""
    file = folder / "python"
    stop = inspect.getsource(stop_m)
    file.write_text(
        PROGRAM.format(
            python=sys.executable, version=version, west=WEST, length=LENGTH_M, stop=stop
        )
    )
    file.chmod(0o755)
    return file


def write_slope(folder: Path, n_events: int = 40, names: Sequence[str] = ("P01",)) -> Path:
    """Write the terrain, the line with a width, and records of known friction."""
    x, y = (np.arange(n) * CELL_M + CELL_M / 2 for n in (220, 60))
    height = 1200.0 + 800.0 * np.exp(-x / 500.0) + 0.0015 * (y[:, None] - 300.0) ** 2
    with rasterio.open(
        folder / "dem.tif", "w", driver="GTiff", height=60, width=220, count=1, dtype="float32",
        crs="EPSG:31287", transform=rasterio.Affine(CELL_M, 0.0, WEST, 0.0, -CELL_M, NORTH),
    ) as file:  # fmt: skip
        file.write(height.astype(np.float32), 1)
    line = shapely.LineString([(WEST + 100.0 + d, NORTH - 300.0) for d in range(0, 1881, 20)])
    pyogrio.raw.write(
        folder / "line.gpkg",
        shapely.to_wkb(np.array([line] * len(names))),
        [np.array(names, dtype=object), np.full(len(names), 80.0)],
        ["path_id", "width_m"],
        geometry_type="LineString",
        crs="EPSG:31287",
        driver="GPKG",
    )
    rng = np.random.default_rng(5)
    with (folder / "events.csv").open("w", newline="") as out:
        rows = csv.writer(out)
        rows.writerow(["event_id", "path_id", "date", "runout_x_m", "runout_sigma_m", "volume_m3"])
        for k in range(n_events):
            volume = float(np.exp(rng.uniform(np.log(3e3), np.log(4e4))))
            friction = LAW[0] * np.exp(-LAW[1] * volume + 0.05 * rng.standard_normal())
            x = stop_m(friction, volume) + 15.0 * rng.standard_normal()
            rows.writerow([f"e{k}", "P01", f"{1970 + k}-02-01", round(x, 1), 15, round(volume)])
    return folder


def real_avaframe() -> str:
    """The Python of the real AvaFrame; the test is skipped where there is none."""
    named = os.environ.get("AVAHAZARD_REAL_AVAFRAME") or ".avaframe-venv/bin/python"
    if not Path(named).exists():
        # The program in AvaFrame's place imports this file, and starts often.
        from tests.conftest import missing  # noqa: PLC0415

        missing("AvaFrame is not there: make avaframe")
    return str(Path(named).absolute())
