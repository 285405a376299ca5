"""GeoPackages, read back by GDAL."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pyogrio
import pytest
import shapely
from pyproj import CRS

from avahazard.gis.hazard_map import MapLayer, hazard_layers, moved_geometry
from avahazard.gis.map_files import (
    is_own_geojson,
    is_own_geopackage,
    layer_style,
    style_text,
    write_geojson,
    write_geopackage,
)
from avahazard.gis.systems import WGS84
from tests.gis.results import bounds_row, zones
from tests.gis.surface import CODE, write_lines
from tests.gis.test_hazard_map import drawn

DAY = np.datetime64("2024-05-06T07:08:09.000")


@pytest.fixture(scope="module")
def layers() -> list[MapLayer]:
    """Give the layers of a model."""
    return hazard_layers([drawn()], [bounds_row(), bounds_row(period=None)], [zones()])


@pytest.fixture(scope="module")
def file(layers: list[MapLayer], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give them as a file."""
    made = tmp_path_factory.mktemp("map") / "map.gpkg"
    write_geopackage(made, layers, DAY)
    return made


def read(file: Path, layer: str) -> tuple[dict[str, Any], list[Any]]:
    """Columns by name, and geometries."""
    meta, _, geometry, columns = pyogrio.raw.read(file, layer=layer)
    table = dict(zip(meta["fields"], (list(c) for c in columns), strict=True))
    return table, [] if geometry is None else list(shapely.from_wkb(geometry))


def test_every_layer_has_its_kind_system_and_features(file: Path, layers: list[MapLayer]) -> None:
    kinds = dict(pyogrio.list_layers(file).tolist())
    assert kinds == {layer.name: layer.kind for layer in layers} | {"layer_styles": None}
    for layer in layers:
        info = pyogrio.read_info(file, layer=layer.name)
        assert (info["crs"], info["features"]) == (CODE, len(layer.features))
        table, geometry = read(file, layer.name)
        assert list(table) == list(layer.features[0].attributes)
        for i, feature in enumerate(layer.features):
            assert geometry[i].equals_exact(feature.geometry, 1e-9)
            for name, value in feature.attributes.items():
                found = table[name][i]
                missing = found is None or found != found  # noqa: PLR0124 (NaN)
                assert missing if value is None else found == value


def test_points_lie_on_the_path_line(file: Path) -> None:
    (line,) = read(file, "paths")[1]
    for layer in ("releases", "events", "design_runouts"):
        for point in read(file, layer)[1]:
            assert line.distance(point) < 0.1


def test_styles_stand_as_qgis_looks_for_them(file: Path, layers: list[MapLayer]) -> None:
    query = (
        "SELECT f_table_name, useAsDefault, styleQML, styleSLD, update_time FROM layer_styles "
        "WHERE f_table_catalog = '' AND f_table_schema = '' AND f_geometry_column = 'geom'"
    )
    with closing(sqlite3.connect(file)) as connection:
        rows = {row[0]: row[1:] for row in connection.execute(query)}
        (key,) = connection.execute(
            "SELECT name FROM pragma_table_info('layer_styles') WHERE pk = 1"
        ).fetchone()
        kinds = dict(connection.execute("SELECT table_name, data_type FROM gpkg_contents"))
    assert (key, kinds["layer_styles"]) == ("id", "attributes")
    assert rows.keys() == {layer.name for layer in layers}
    for default, as_qml, as_sld, time in rows.values():
        assert default == 1
        assert ElementTree.fromstring(as_qml).tag == "qgis"
        assert ElementTree.fromstring(as_sld).tag.endswith("StyledLayerDescriptor")
        assert time.startswith("2024-05-06T07:08:09")


def test_a_file_is_known_as_our_own(file: Path, tmp_path: Path) -> None:
    assert is_own_geopackage(file)
    other = write_lines(tmp_path / "lines.gpkg", [[(0, 0), (1, 1)]], {"path_id": ["P"]})
    assert not is_own_geopackage(other)
    words = tmp_path / "words.gpkg"
    words.write_text("words")
    assert not is_own_geopackage(words)


LAYERS = {m.name: m for m in hazard_layers([drawn()], [bounds_row()], [zones()])}
SPACES = {"se": "http://www.opengis.net/se", "ogc": "http://www.opengis.net/ogc"}


@pytest.mark.parametrize("layer", LAYERS.values(), ids=LAYERS)
def test_every_category_has_a_symbol_and_every_feature_a_category(layer: MapLayer) -> None:
    style = layer_style(layer)
    root = ElementTree.fromstring(style_text("qml", layer))
    renderer = root.find("renderer-v2")
    assert renderer is not None
    symbols = [s.get("name") for s in renderer.findall("symbols/symbol")]
    assert [s.get("type") for s in renderer.findall("symbols/symbol")] == [
        {"Point": "marker", "LineString": "line", "Polygon": "fill"}[layer.kind]
    ] * len(symbols)
    rules = ElementTree.fromstring(style_text("sld", layer)).findall(".//se:Rule", SPACES)
    if style.attribute is None:
        assert (renderer.get("type"), symbols, len(rules)) == ("singleSymbol", ["0"], 1)
        return
    categories = renderer.findall("categories/category")
    assert [c.get("symbol") for c in categories] == symbols
    values = {c.get("value") for c in categories}
    assert {f.attributes[style.attribute] for f in layer.features} <= values
    literals = {r.findtext(".//ogc:Literal", namespaces=SPACES) for r in rules}
    assert literals == values


def test_zones_have_their_own_colours() -> None:
    red = ElementTree.fromstring(style_text("qml", LAYERS["zones"])).find(
        ".//Option[@name='line_color']"
    )
    assert red is not None
    assert red.get("value") == "200,16,46,255"
    assert "#c8102e" in style_text("sld", LAYERS["zones"])


def test_one_collection_in_degrees_with_the_kind_of_each_feature(tmp_path: Path) -> None:
    layers = hazard_layers([drawn(), drawn("Q", crs="EPSG:32632")], [bounds_row()], [zones()])
    file = tmp_path / "map.geojson"
    write_geojson(file, layers)
    collection = json.loads(file.read_text(encoding="utf-8"))
    assert collection["type"] == "FeatureCollection"
    assert "crs" not in collection
    features = collection["features"]
    assert len(features) == sum(len(layer.features) for layer in layers)
    kinds = {f["properties"]["kind"] for f in features}
    assert kinds == {
        "paths",
        "zones",
        "zone_areas",
        "releases",
        "events",
        "volume_runouts",
        "design_runouts",
    }
    originals = [f for layer in layers for f in layer.features]
    for made, feature in zip(features, originals, strict=True):
        shape = shapely.geometry.shape(made["geometry"])
        if shape.geom_type == "Polygon":
            assert shape.exterior.is_ccw
        back = moved_geometry(shape, WGS84, CRS(feature.line.code))
        assert back.hausdorff_distance(feature.geometry) < 0.1
        assert made["properties"]["path_id"] == feature.attributes["path_id"]
    lon, lat = features[0]["geometry"]["coordinates"][0][0]
    assert (lon, lat) == pytest.approx((11.4, 47.3), abs=0.3)
    assert pyogrio.read_info(file)["crs"] == "EPSG:4326"
    assert layers[0].code == CODE


def test_a_file_is_known_as_our_own_of_geojson(tmp_path: Path) -> None:
    file = tmp_path / "map.geojson"
    write_geojson(file, hazard_layers([drawn()], [], []))
    assert is_own_geojson(file)
    file.write_text('{"type": "FeatureCollection", "features": []}')
    assert not is_own_geojson(file)
