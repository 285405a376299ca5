"""Results of a model as files."""

from __future__ import annotations

import csv
import json
from pathlib import Path as FilePath

import numpy as np
import pyogrio
import pytest
import shapely

from avahazard import gis
from avahazard.records.collection import Event, Path, Records
from avahazard.records.errors import AvahazardError
from avahazard.results.files import Layer
from avahazard.store import upkeep
from avahazard.store.records import load_records, save_records
from avahazard.store.results import BOUNDS, ZONES
from avahazard.store.session import reading, writing
from avahazard.workflow.database import import_files
from avahazard.workflow.export import export
from tests.gis.results import bounds_row, profile, zones
from tests.gis.surface import write_lines
from tests.store.documents import save_bare, save_documents
from tests.telling import untold

PATHS = (Path("P", covariates={"width_m": 60.0}), Path("Q", release_elevation_m=1900.0), Path("R"))
EVENTS = (
    Event("e", "P", date="1950", runout_x_m=700.0, volume_m3=4e3),
    Event("f", "Q", runout_elevation_m=1650.0),
    Event("g", "Q", left_profile=True),
)


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with paths P and Q on the map, R off it, and results by `base`; do not
    write to it."""
    file = str(tmp_path_factory.mktemp("stored") / "stored.db")
    upkeep.create(file)
    off = profile("R", crs=None)
    with writing(file) as session:
        records = Records(PATHS, (profile("P"), profile("Q", east=900.0), off), EVENTS)
        save_records(session, records)
        save_bare(session, "base")
        save_bare(session, "bare")
        save_documents(
            session,
            BOUNDS,
            "base",
            [bounds_row("P").to_dict(), bounds_row("Q").to_dict(), bounds_row("R").to_dict()],
        )
        save_documents(session, ZONES, "base", [zones("P").to_dict(), zones("Q").to_dict()])
    return file


def layers(file: FilePath) -> dict[str, tuple[str, int]]:
    """System and number of features of the layers on the map."""
    infos = {
        name: pyogrio.read_info(file, layer=name)
        for name, kind in pyogrio.list_layers(file)
        if kind
    }
    return {name: (info["crs"], info["features"]) for name, info in infos.items()}


def test_a_geopackage_with_every_layer(stored: str, tmp_path: FilePath) -> None:
    file = tmp_path / "map.gpkg"
    done = export(stored, "base", file)
    expected = {
        "zone_areas": 2,
        "paths": 2,
        "zones": 4,
        "releases": 2,
        "events": 2,
        "volume_runouts": 4,
        "design_runouts": 6,
    }
    assert layers(file) == {name: ("EPSG:31287", n) for name, n in expected.items()}
    assert {x.layer: x.n_features for x in done.layers} == expected
    assert [f.name for f in tmp_path.iterdir()] == ["map.gpkg"]
    notes = "\n".join(done.notes)
    assert untold(notes, "R", "crs", "width_m: Q") == []
    lines = shapely.from_wkb(pyogrio.raw.read(file, layer="paths")[2])
    for layer in ("releases", "events", "design_runouts"):
        points = shapely.from_wkb(pyogrio.raw.read(file, layer=layer)[2])
        off = np.min([shapely.distance(line, points) for line in lines], axis=0)
        assert off.max() < 0.1


def test_the_other_files(stored: str, tmp_path: FilePath) -> None:
    export(stored, "base", tmp_path / "map.geojson")
    assert len(json.loads((tmp_path / "map.geojson").read_text())["features"]) == 22
    done = export(stored, "base", tmp_path / "bounds.csv")
    with (tmp_path / "bounds.csv").open(newline="") as handle:
        assert [row["path_id"] for row in csv.DictReader(handle)] == ["P", "Q", "R"]
    assert done.layers == (Layer("hazard", 3, None),)
    assert any("no zones" in note for note in done.notes)
    done = export(stored, "base", tmp_path / "bounds.xlsx")
    assert done.layers == (Layer("hazard", 3, None), Layer("zones", 6, None))
    assert not any("zones" in note for note in done.notes)


@pytest.mark.parametrize("name", ["out.gpkg", "out.geojson", "out.csv", "out.xlsx"])
def test_only_an_export_is_replaced(stored: str, tmp_path: FilePath, name: str) -> None:
    file = tmp_path / name
    for _ in range(2):
        export(stored, "base", file)
    file.unlink()
    if name == "out.gpkg":
        write_lines(file, [[(0, 0), (1, 1)]], {"path_id": ["P"]})
    else:
        file.write_text("{}")
    before = file.read_bytes()
    with pytest.raises(AvahazardError, match="no export made it"):
        export(stored, "base", file)
    assert file.read_bytes() == before
    assert [f.name for f in tmp_path.iterdir()] == [name]


def test_what_cannot_be_exported(stored: str, tmp_path: FilePath) -> None:
    for model, name, message, hint in (
        ("base", "map.kml", "does not end in", "GeoPackage"),
        ("base", "none/map.gpkg", "no folder", "Make"),
        ("nobody", "map.gpkg", "no model nobody", "base"),
        ("bare", "map.gpkg", "No bounds are stored by bare", "avahazard hazard bare"),
    ):
        with pytest.raises(AvahazardError, match=message) as caught:
            export(stored, model, tmp_path / name)
        assert hint in caught.value.hint
    assert list(tmp_path.iterdir()) == []


def test_no_coordinates_at_all(database: str, tmp_path: FilePath) -> None:
    with writing(database) as session:
        save_records(session, Records((Path("P"), Path("Q")), (profile("P", crs=None),)))
        save_bare(session, "base")
        save_documents(session, BOUNDS, "base", [bounds_row("P").to_dict()])
    with pytest.raises(
        AvahazardError, match="P: coordinates without a crs; Q: no profile"
    ) as caught:
        export(database, "base", tmp_path / "map.gpkg")
    assert ".csv" in caught.value.hint
    export(database, "base", tmp_path / "bounds.csv")


def test_the_table_needs_no_packages(
    stored: str, tmp_path: FilePath, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gis, "find_spec", lambda _name: None)
    export(stored, "base", tmp_path / "bounds.csv")
    with pytest.raises(AvahazardError, match="rasterio") as caught:
        export(stored, "base", tmp_path / "map.gpkg")
    assert "avahazard[gis]" in caught.value.hint


def test_the_tyrol_profiles_go_through_to_a_map(
    shared_data: FilePath, database: str, tmp_path: FilePath
) -> None:
    source = (shared_data / "tyrol-profiles" / "profiles.csv").read_text()
    head, *rows = source.splitlines()
    file = tmp_path / "profiles.csv"
    file.write_text("\n".join([f"{head},crs", *(f"{row},EPSG:31287" for row in rows)]) + "\n")
    import_files(database, [file])
    with reading(database) as session:
        records = load_records(session)
    names = [path.path_id for path in records.paths]
    assert len(names) == 9
    with writing(database) as session:
        save_bare(session, "base")
        save_documents(session, BOUNDS, "base", [bounds_row(name).to_dict() for name in names])
        save_documents(session, ZONES, "base", [zones(name).to_dict() for name in names])
    done = export(database, "base", tmp_path / "tyrol.gpkg")
    found = layers(tmp_path / "tyrol.gpkg")
    assert {crs for crs, _ in found.values()} == {"EPSG:31287"}
    assert found["paths"][1] == found["releases"][1] == 9
    assert found["zones"][1] == 18
    assert not [note for note in done.notes if "not on the map" in note]
    # The extent of the map is in Tyrol.
    west, south, east, north = pyogrio.read_info(tmp_path / "tyrol.gpkg", layer="paths")[
        "total_bounds"
    ]
    assert 150_000 < west < east < 350_000
    assert 330_000 < south < north < 420_000
