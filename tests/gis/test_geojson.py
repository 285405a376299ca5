"""GeoJSON (RFC 7946)."""

from __future__ import annotations

import json
from pathlib import Path

import pyogrio
import pytest
import shapely
from pyproj import CRS

from avahazard.gis.geojson import is_own_geojson, write_geojson
from avahazard.gis.hazard_map import hazard_layers
from avahazard.gis.path_line import moved_geometry
from avahazard.gis.systems import WGS84
from tests.gis.results import bounds, zones
from tests.gis.surface import CODE
from tests.gis.test_hazard_map import drawn


def test_one_collection_in_degrees_with_the_kind_of_each_feature(tmp_path: Path) -> None:
    layers = hazard_layers([drawn(), drawn("Q", crs="EPSG:32632")], [bounds()], [zones()])
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


def test_a_file_is_known_as_our_own(tmp_path: Path) -> None:
    file = tmp_path / "map.geojson"
    write_geojson(file, hazard_layers([drawn()], [], []))
    assert is_own_geojson(file)
    file.write_text('{"type": "FeatureCollection", "features": []}')
    assert not is_own_geojson(file)
