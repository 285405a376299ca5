"""GeoPackages, read back by GDAL."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pyogrio
import pytest
import shapely

from avahazard.gis.geopackage import is_own_geopackage, write_geopackage
from avahazard.gis.hazard_map import hazard_layers
from avahazard.gis.map_layer import MapLayer
from tests.gis.results import bounds, zones
from tests.gis.surface import CODE, write_lines
from tests.gis.test_hazard_map import drawn

DAY = np.datetime64("2024-05-06T07:08:09.000")


@pytest.fixture(scope="module")
def layers() -> list[MapLayer]:
    """Give the layers of a made-up model."""
    return hazard_layers([drawn()], [bounds(), bounds(period=None)], [zones()])


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
    for default, qml, sld, time in rows.values():
        assert default == 1
        assert ElementTree.fromstring(qml).tag == "qgis"
        assert ElementTree.fromstring(sld).tag.endswith("StyledLayerDescriptor")
        assert time.startswith("2024-05-06T07:08:09")


def test_a_file_is_known_as_our_own(file: Path, tmp_path: Path) -> None:
    assert is_own_geopackage(file)
    other = write_lines(tmp_path / "lines.gpkg", [[(0, 0), (1, 1)]], {"path_id": ["P"]})
    assert not is_own_geopackage(other)
    words = tmp_path / "words.gpkg"
    words.write_text("words")
    assert not is_own_geopackage(words)
