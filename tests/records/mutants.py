"""Inputs of the new forms, and mutants of them: bytes cut, doubled, swapped, made others."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np

from tests.gis.surface import BOTTOM, TOP, write_dem, write_lines
from tests.records.office import Office, write

MAPPING = """header = 3
units = 4
unknown = ["?", -9999]
need = ["Volumen"]
[columns]
event_id = "Lawinen-Nr"
path_id = {value = "P"}
date = "Datum"
runout_elevation_m = {from = "Auslaufhöhe", unit = "m"}
volume_m3 = {from = "Volumen", range = "geometric", classes = {D1 = 100}}
"""
KML = (
    '<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>K'
    "</name><LineString><coordinates>{}</coordinates></LineString></Placemark></Document></kml>"
)
GPX = (
    '<?xml version="1.0"?><gpx version="1.1" creator="x" xmlns="http://www.topografix.com/GPX/1/1">'
    "<trk><name>G</name><trkseg>{}</trkseg></trk></gpx>"
)
ODD = (b"", b"\x00", b"-", b"9" * 40, b"nan", b"1e999", b"<", b'"', b"]", b"\xff\xfe", b"\n", b";")


def seeds(folder: Path) -> list[tuple[Path, list[Path]]]:
    """Write inputs of the new forms: what to import, and the files of it that mutate."""
    corners = degrees()
    write_dem(folder / "dem.tif", cell=40.0, width=40, height=42)
    (folder / "k.kml").write_text(KML.format(" ".join(f"{x},{y},0" for x, y in corners)))
    points = "".join(f'<trkpt lon="{x}" lat="{y}"/>' for x, y in corners)
    (folder / "g.gpx").write_text(GPX.format(points))
    found = [(folder / name, [folder / name]) for name in ("k.kml", "g.gpx")]
    office = Office(
        title=True, units=True, merged=False, language="de", mark="?", dates="cell", format=""
    )
    for name in ("ods", "xls", "xlsx", "csv"):
        file, mapping = folder / name / f"events.{name}", folder / name / "columns.toml"
        file.parent.mkdir()
        write(file, office._replace(format=name))
        mapping.write_text(MAPPING, encoding="utf-8")
        found.append((file, [file, mapping]))
    inputs = folder / "avaF" / "Inputs"
    (inputs / "LINES").mkdir(parents=True)
    write_dem(inputs / "dem.asc", cell=40.0, width=40, height=42, crs=None)
    write_lines(inputs / "LINES" / "path_aimec.shp", [[TOP, BOTTOM]], {"name": ["p"]})
    files = [f for f in inputs.rglob("*") if f.is_file() and f.suffix in (".asc", ".shp", ".dbf")]
    return [*found, (folder / "avaF", files)]


def degrees() -> list[tuple[float, float]]:
    """The corners of a line on the terrain model, in degrees."""
    from avahazard.gis.systems import WGS84, moved, read_system  # noqa: PLC0415

    system = read_system("EPSG:31287")
    assert system is not None
    return [(float(x), float(y)) for x, y in moved(np.array([TOP, BOTTOM]), system, WGS84)]


def mutant(raw: bytes, rng: np.random.Generator) -> bytes:
    """`raw` with one to three faults; of an archive often in one of its members."""
    if raw.startswith(b"PK") and rng.random() < 0.7:
        return _in_archive(raw, rng)
    for _ in range(int(rng.integers(1, 4))):
        if not raw:
            break
        at, to = sorted(int(k) for k in rng.integers(0, len(raw), 2))
        to = min(to, at + int(rng.integers(1, 60)))
        kind = rng.integers(0, 5)
        if kind == 0:
            raw = raw[:at] + raw[to:]
        elif kind == 1:
            raw = raw[:to] + raw[at:]
        elif kind == 2:
            raw = raw[:at] + ODD[int(rng.integers(len(ODD)))] + raw[to:]
        elif kind == 3:
            raw = raw[:at] + bytes([int(rng.integers(256))]) + raw[at + 1 :]
        else:
            raw = raw[: max(at, 1)]
    return raw


def _in_archive(raw: bytes, rng: np.random.Generator) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(raw)) as old, zipfile.ZipFile(out, "w") as new:
        names = old.namelist()
        chosen = names[int(rng.integers(len(names)))]
        for name in names:
            data = old.read(name)
            new.writestr(name, mutant(data, rng) if name == chosen else data)
    return out.getvalue()
