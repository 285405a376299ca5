"""Valleys alike along their line, from open to narrow, and what com1DFA of AvaFrame 2.1 did there.

    python -m tests.engines.valleys FOLDER

runs it there anew, with the AvaFrame that `simulate` finds (20 minutes of a core), and writes
`valleys.npz` beside this file.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pyogrio
import rasterio
import shapely

from avahazard.records.collection import Simulation, find_path, find_profile, ground_of
from avahazard.store.records import load_records, load_simulations, load_terrain, save_simulation
from avahazard.store.session import reading, writing
from tests.conftest import command_line
from tests.engines.slope import CELL_M, NORTH, WEST

NARROW = (0.0002, 0.0006, 0.0012, 0.0025, 0.005, 0.009)
"""How fast (1/m) the ground rises across each valley: its height is this times the square of y."""
NAMES = tuple(f"V{k}" for k in range(1, len(NARROW) + 1))
FRICTIONS, VOLUMES = np.round(np.linspace(0.24, 0.52, 8), 3), (3000.0, 11_000.0, 40_000.0)
WITH_PEAKS = "V3"
FILE = Path(__file__).with_suffix(".npz")
WIDE, ROWS, COLUMNS = 60, 60 * len(NARROW), 220


def write_valleys(folder: Path) -> None:
    """Write the terrain and the lines, each with a width."""
    x = (np.arange(COLUMNS) + 0.5) * CELL_M
    across = (np.arange(ROWS) % WIDE + 0.5 - WIDE / 2) * CELL_M
    narrow = np.repeat(NARROW, WIDE)
    height = 1200.0 + 800.0 * np.exp(-x / 500.0) + (narrow * across**2)[:, None]
    with rasterio.open(
        folder / "dem.tif", "w", driver="GTiff", height=ROWS, width=COLUMNS, count=1,
        dtype="float32", crs="EPSG:31287",
        transform=rasterio.Affine(CELL_M, 0.0, WEST, 0.0, -CELL_M, NORTH),
    ) as file:  # fmt: skip
        file.write(height.astype(np.float32), 1)
    lines = [
        shapely.LineString(
            [(WEST + 100.0 + d, NORTH - (k + 0.5) * WIDE * CELL_M) for d in range(0, 1881, 20)]
        )
        for k in range(len(NARROW))
    ]
    pyogrio.raw.write(
        folder / "lines.gpkg",
        shapely.to_wkb(np.array(lines)),
        [np.array(NAMES, dtype=object), np.full(len(NAMES), 80.0)],
        ["path_id", "width_m"],
        geometry_type="LineString",
        crs="EPSG:31287",
        driver="GPKG",
    )


def import_valleys(folder: Path) -> str:
    """Write the valleys, and import them into a new database there."""
    write_valleys(folder)
    database = str(folder / "valleys.db")
    run = command_line(database)
    for words in (
        ["init"],
        ["import", str(folder / "lines.gpkg"), "--dem", str(folder / "dem.tif")],
    ):
        done = run(*words)
        assert done.exit_code == 0, done.output
    return database


def store_recorded(database: str) -> list[Simulation]:
    """Store the recorded runs as if they had been made here; only one valley has its pressures."""
    kept = np.load(FILE)
    runs = []
    with writing(database) as session:
        records = load_records(session)
        for name in NAMES:
            path = find_path(records, name)
            crop = load_terrain(session, name)
            assert crop is not None
            ground = ground_of(path, find_profile(records, path), crop)
            blank = np.zeros(crop.elevation_m.shape, np.float32)
            for k, stop in np.ndenumerate(kept["stop_x_m"][NAMES.index(name)]):
                peak = kept["peak_kpa"][k].astype(np.float32) if name == WITH_PEAKS else blank
                left = bool(kept["left"][NAMES.index(name)][k])
                at = float(FRICTIONS[k[0]]), VOLUMES[k[1]], 0.0, float(stop), left, 1.0, peak
                runs.append(Simulation(name, "com1dfa", ground, *at))
                save_simulation(session, runs[-1])
    return runs


def record(folder: Path) -> None:
    """Run com1DFA on all valleys and keep the stops, and the peak pressures of one."""
    database = folder / "valleys.db"
    if not database.exists():
        import_valleys(folder)
    asked = [f"--friction={mu}" for mu in FRICTIONS] + [f"--volume={v:g}" for v in VOLUMES]
    done = command_line(str(database))("simulate", *asked)
    assert done.exit_code == 0, done.output
    with reading(str(database)) as session:
        runs = {(r.path_id, r.friction, r.volume_m3): r for r in load_simulations(session)}
        peaks = {
            (r.friction, r.volume_m3): r.peak_kpa
            for r in load_simulations(session, lambda c: c == WITH_PEAKS, peaks=True)
        }
    grid = [[[runs[name, float(mu), v] for v in VOLUMES] for mu in FRICTIONS] for name in NAMES]
    np.savez_compressed(
        FILE,
        stop_x_m=np.array([[[r.stop_x_m for r in row] for row in one] for one in grid]),
        left=np.array([[[r.left_profile for r in row] for row in one] for one in grid]),
        peak_kpa=np.array([[peaks[float(mu), v] for v in VOLUMES] for mu in FRICTIONS], np.float16),
    )


if __name__ == "__main__":
    record(Path(sys.argv[1]))
