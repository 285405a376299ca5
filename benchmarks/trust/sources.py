"""The files that are mutated, one of each form, and how each is read."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from avahazard.effects.own_file import TEMPLATE, definition_from, read_text
from avahazard.hazard.frequency import read_return_volumes
from avahazard.hazard.zones import read_limits
from avahazard.workflow.database import import_files
from avahazard.workflow.requests import ImportRequest
from avahazard.workflow.run import read_project
from benchmarks.trust import mutants
from benchmarks.trust.commands import PROJECT

Mutate = Callable[[bytes, np.random.Generator], bytes]
VELOCITIES = "event_id,x_m,speed_m_s,speed_sigma_m_s\n" + "".join(
    f"P01-00{k},{400 + 100 * k},{20 + k},3\n" for k in range(1, 7)
)
STRAIGHT = "event_id,fall_height_m,runout_length_m,volume_m3,kind\n" + "".join(
    f"s{k},{900 + k},{1500 + 37 * k},{2000 + 900 * k},{'ab'[k % 2]}\n" for k in range(12)
)
VOLUMES = (
    "path_id,return_period_years,volume_m3\nP01,10,2e4\nP01,100,9e4\nP02,10,1e4\nP02,100,7e4\n"
)
LIMITS = """
[[zone]]
name = "red"
color = "#c8102e"
[[zone.rule]]
return_period_years = 30
pressure_kpa_min = 3.0
"""


@dataclass(frozen=True, slots=True)
class Source:
    """A form: the right file, its mutator, and what reads a mutant in a database with records.

    `chain` says that what is accepted can be calibrated on.
    """

    form: str
    file: str
    content: bytes
    mutate: Mutate
    read: Callable[[str, Path], object]
    chain: bool = False


def sources(folder: Path) -> list[Source]:
    """All forms; `folder` holds the dataset whose files are mutated, and takes the terrain."""
    world = {name: (folder / "world" / f"{name}.csv").read_text() for name in FORMS}
    found = [
        Source(name, f"{name}.csv", world[name].encode(), _table(","), _import, chain=True)
        for name in FORMS
    ]
    semicolons = "\n".join(
        line.replace(".", ",") if k else line
        for k, line in enumerate(world["events"].replace(",", ";").splitlines())
    )
    workbook = _workbook(folder / "world")
    found += [
        Source("events with ;", "events.csv", semicolons.encode(), _table(";"), _import, True),
        Source("events by H, L", "events.csv", STRAIGHT.encode(), _table(","), _import, chain=True),
        Source("velocities", "velocities.csv", VELOCITIES.encode(), _table(","), _import),
        Source("workbook", "events.xlsx", workbook, mutants.mutate_workbook, _import, True),
        Source("volumes", "volumes.csv", VOLUMES.encode(), _table(","), _just(read_return_volumes)),
        Source("avahazard.toml", "avahazard.toml", PROJECT.encode(), _text, _just(read_project)),
        Source("limits", "limits.toml", LIMITS.encode(), _text, _read_limits),
        Source("effect file", "effect.py", TEMPLATE.encode(), _text, _read_effect),
    ]  # fmt: skip
    return found + _terrain(folder / "terrain")


FORMS = ("paths", "profiles", "events")


def _import(database: str, file: Path, **given: Path) -> object:
    return import_files(database, [file], ImportRequest(update=True, dry_run=True, **given))


def _just(read: Callable[[Path], object]) -> Callable[[str, Path], object]:
    return lambda _, file: read(file)


def _read_effect(_: str, file: Path) -> object:
    return definition_from(read_text(file), str(file))


def _read_limits(_: str, file: Path) -> object:
    return read_limits(file.name, file.read_text(encoding="utf-8", errors="replace"))


def _table(separator: str) -> Mutate:
    return lambda data, rng: mutants.mutate_table(data.decode(), rng, separator)


def _text(data: bytes, rng: np.random.Generator) -> bytes:
    return mutants.mutate_text(data.decode(), rng)


def _workbook(folder: Path) -> bytes:
    made = io.BytesIO()
    with pd.ExcelWriter(made) as book:
        for name in FORMS:
            pd.read_csv(folder / f"{name}.csv").to_excel(book, sheet_name=name, index=False)
    return made.getvalue()


def _terrain(folder: Path) -> list[Source]:
    """Two lines on a slope, as a GeoPackage and as GeoJSON, and the terrain as .tif and .asc."""
    try:
        import pyogrio  # noqa: PLC0415 (may be missing)
        import rasterio  # noqa: PLC0415
        import shapely  # noqa: PLC0415
    except ImportError:
        return []
    folder.mkdir(exist_ok=True)
    cell, west, north, code = 20.0, 255_000.0, 382_000.0, "EPSG:31287"
    down = (np.arange(80) + 0.5)[:, None] * cell
    across = (np.arange(60) + 0.5)[None, :] * cell
    ground = (2400.0 - 0.9 * down + 2.2e-4 * down**2 + 15.0 * np.sin(across / 180.0)).astype("f4")
    profile = {
        "width": 60, "height": 80, "count": 1, "dtype": "float32", "crs": code, "nodata": -9999.0,
        "transform": rasterio.Affine(cell, 0.0, west, 0.0, -cell, north),
    }  # fmt: skip
    for name, driver in (("dem.tif", "GTiff"), ("dem.asc", "AAIGrid")):
        with rasterio.open(folder / name, "w", driver=driver, **profile) as target:
            target.write(ground, 1)
    lines = [
        shapely.LineString([(west + 300 * k, north - 100), (west + 280 * k, north - 1400)])
        for k in (1, 3)
    ]
    for name in ("lines.gpkg", "lines.geojson"):
        pyogrio.raw.write(
            folder / name,
            geometry=shapely.to_wkb(np.array(lines, dtype=object)),
            field_data=[np.array(["G1", "G2"]), np.array([12.0, 30.0])],
            fields=["path_id", "width_m"],
            geometry_type="LineString",
            crs=code,
        )

    def on_terrain(database: str, file: Path) -> object:
        return _import(database, file, dem=folder / "dem.tif")

    def under_lines(database: str, file: Path) -> object:
        return _import(database, folder / "lines.gpkg", dem=file)

    return [
        Source(name, name, (folder / name).read_bytes(), mutants.mutate_bytes, read)
        for name, read in (
            ("lines.gpkg", on_terrain), ("lines.geojson", on_terrain),
            ("dem.tif", under_lines), ("dem.asc", under_lines),
        )
    ]  # fmt: skip
