"""Layers of lines and polygons."""

from __future__ import annotations

import sqlite3
import warnings
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import shapely
from pyproj import CRS

from avahazard.gis.vector_layer import cover_at, read_layer
from avahazard.records.errors import AvahazardError
from tests.gis.surface import BOTTOM, CODE, NORTH, TOP, WEST, write_lines

SQUARE = shapely.box(0.0, 0.0, 1.0, 1.0)


def test_attributes_are_the_text_of_a_table(tmp_path: Path) -> None:
    columns = {
        "path_id": ["P", " Q "],
        "observed_from": [1950.0, np.nan],
        "width_m": [80.25, 1e300],
        "count": [3, -4],
        "forest": [True, False],
        "seen": np.array(["2020-01-31", "NaT"], "datetime64[D]").tolist(),
        "section": [None, ""],
    }
    columns["seen"] = list(np.array(["2020-01-31", "NaT"], "datetime64[ms]"))
    layer = read_layer(write_lines(tmp_path / "a.gpkg", [[TOP, BOTTOM]] * 2, columns), "line")
    first, second = layer.attributes
    assert first == {
        "path_id": "P",
        "observed_from": "1950",
        "width_m": "80.25",
        "count": "3",
        "forest": "1",
        "seen": "2020-01-31T00:00:00.000",
    }
    assert second == {"path_id": "Q", "width_m": "1e+300", "count": "-4", "forest": "0"}
    assert (layer.crs.to_epsg(), len(layer.geometry)) == (31287, 2)


@pytest.mark.parametrize("name", ["a.shp", "a.geojson"])
def test_other_files(tmp_path: Path, name: str) -> None:
    crs = "EPSG:4326" if name.endswith("json") else "EPSG:31287"
    file = write_lines(tmp_path / name, [[(11.0, 47.0), (11.1, 47.0)]], {"name": ["P"]}, crs)
    layer = read_layer(file, "line")
    assert (layer.crs.to_epsg(), layer.attributes[0]["name"]) == (int(crs[5:]), "P")


def test_the_layer_of_lines_is_taken_among_others(tmp_path: Path) -> None:
    file = tmp_path / "a.gpkg"
    write_lines(file, [[TOP, BOTTOM]], {"path_id": ["P"]}, layer="paths")
    write_lines(file, [SQUARE], {"land_cover": ["forest"]}, layer="forest")
    assert read_layer(file, "line").columns == ("path_id",)
    assert read_layer(file, "polygon").columns == ("land_cover",)
    write_lines(file, [[TOP, BOTTOM]], {"path_id": ["P"]}, layer="roads")
    with pytest.raises(AvahazardError, match="2 layers of lines: paths, roads") as caught:
        read_layer(file, "line")
    assert "forest (Polygon)" in caught.value.hint


def test_only_features_near_some_points(tmp_path: Path) -> None:
    far = shapely.box(500.0, 500.0, 501.0, 501.0)
    file = write_lines(tmp_path / "a.gpkg", [far, SQUARE], {"land_cover": ["rock", "forest"]})
    whole = read_layer(file, "polygon")
    near = read_layer(file, "polygon", near=(np.array([[0.5, 0.5], [3.0, 3.0]]), whole.crs))
    assert [row["land_cover"] for row in near.attributes] == ["forest"]


def test_heights_and_measures_are_left_out_without_a_word(tmp_path: Path) -> None:
    line = shapely.LineString([(0.0, 0.0, 7.0), (1.0, 1.0, 8.0)])
    file = write_lines(tmp_path / "a.gpkg", [line], {"path_id": ["P"]}, kind="LineString Z")
    with closing(sqlite3.connect(file)) as connection:
        connection.execute("UPDATE gpkg_geometry_columns SET z = 0, m = 1")
        connection.commit()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not read_layer(file, "line").geometry[0].has_z


def test_files_that_cannot_be_used(tmp_path: Path) -> None:
    words = tmp_path / "words.gpkg"
    words.write_text("no map")
    table = write_lines(tmp_path / "points.gpkg", [shapely.Point(0, 0)], {"path_id": ["P"]})
    columns = {"path_id": ["P"]}
    with pytest.warns(UserWarning, match="crs"):
        bare = write_lines(tmp_path / "bare.gpkg", [[TOP, BOTTOM]], columns, crs=None)
    with pytest.warns(UserWarning, match="crs"):
        shape = write_lines(tmp_path / "bare.shp", [[TOP, BOTTOM]], columns, crs=None)
    for file, message, hint in (
        (tmp_path / "none.shp", "no file", ".gpkg"),
        (words, "cannot be read", "GeoPackage"),
        (table, "no layer of lines", "points (Point)"),
        (bare, "no reference system", "in your GIS"),
        (shape, "no reference system", "bare.prj"),
    ):
        with pytest.raises(AvahazardError, match=message) as caught:
            read_layer(file, "line")
        assert hint in caught.value.hint


def test_text_that_is_not_utf_8_is_told(tmp_path: Path) -> None:
    file = write_lines(tmp_path / "a.geojson", [[TOP, BOTTOM]], {"path_id": ["P"]})
    file.write_bytes(file.read_bytes().replace(b'"properties"', b'"prop\x8brties"'))
    with pytest.raises(AvahazardError, match="not UTF-8"):
        read_layer(file, "line")


XY = np.array([WEST, NORTH]) + np.array([[10.0, 0.0], [60.0, 0.0], [110.0, 0.0], [500.0, 0.0]])


def box(west: float, east: float) -> shapely.Geometry:
    return shapely.box(WEST + west, NORTH - 50.0, WEST + east, NORTH + 50.0)


def test_the_first_polygon_counts_and_all_else_is_open(tmp_path: Path) -> None:
    shapes = [box(50, 100), box(0, 120), None, box(0, 600)]
    cover = {"land_cover": ["forest", "rock", "water", None]}
    file = write_lines(tmp_path / "cover.gpkg", shapes, cover)
    assert cover_at(file, XY, CRS(CODE)) == ("rock", "forest", "rock", "open")


def test_polygons_in_another_system_and_none_near(tmp_path: Path) -> None:
    file = write_lines(
        tmp_path / "cover.geojson",
        [shapely.box(11.3, 47.0, 11.6, 47.6), shapely.box(60.0, 60.0, 61.0, 61.0)],
        {"land_cover": ["forest", "rock"]},
        crs="EPSG:4326",
    )
    found = cover_at(file, np.array([[255_000.0, 382_000.0], [400_000.0, 382_000.0]]), CRS(CODE))
    assert found == ("forest", "open")
    assert cover_at(file, np.array([[400_000.0, 382_000.0]]), CRS(CODE)) == ("open",)


def test_polygons_without_the_attribute(tmp_path: Path) -> None:
    file = write_lines(tmp_path / "cover.gpkg", [box(0, 1)], {"kind": ["forest"]})
    with pytest.raises(AvahazardError, match="no attribute land_cover") as caught:
        cover_at(file, XY, CRS(CODE))
    assert "kind" in caught.value.hint
