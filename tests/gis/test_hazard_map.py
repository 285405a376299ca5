"""The layers of a model's results."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from pyproj import Geod

from avahazard.gis.hazard_map import MapLayer, MappedPath, PathLine, hazard_layers, path_line
from avahazard.records.collection import Covariate, Event, Path
from tests.gis.results import bounds_row, profile, zones
from tests.gis.surface import CODE, NORTH, WEST


def drawn(path_id: str = "P", width: Covariate | None = 80.0, **more: Any) -> MappedPath:
    """Give a path with a stop on it, and one off it."""
    line = path_line(profile(path_id, **more))
    assert isinstance(line, PathLine)
    path = Path(path_id, section="open", covariates={} if width is None else {"width_m": width})
    events = ((Event("e", path_id, date="1950", volume_m3=5e3), 600.0), (Event("f", path_id), 1e4))
    return MappedPath(path, line, 120.0, events)


def by_name(layers: list[MapLayer]) -> dict[str, MapLayer]:
    """Layers under their names."""
    return {layer.name: layer for layer in layers}


def test_every_layer_with_its_attributes() -> None:
    found = by_name(hazard_layers([drawn()], [bounds_row(), bounds_row("other")], [zones()]))
    assert {name: len(layer.features) for name, layer in found.items()} == {
        "zone_areas": 2,
        "paths": 1,
        "zones": 2,
        "releases": 1,
        "events": 1,
        "volume_runouts": 2,
        "design_runouts": 3,
    }
    path = found["paths"].features[0].attributes
    assert (path["path_id"], path["width_m"], path["length_m"]) == ("P", 80.0, 1000.0)
    assert found["releases"].features[0].attributes["x_m"] == 120.0
    assert found["events"].features[0].attributes["event_id"] == "e"
    red, blue = found["zones"].features
    assert (red.attributes["zone"], red.attributes["color"]) == ("red", "#c8102e")
    assert red.geometry.length == pytest.approx(550.0)
    assert blue.geometry.length == pytest.approx(350.0)
    assert (blue.attributes["to_x_m"], blue.attributes["beyond_profile"]) == (1200.0, True)
    area = found["zone_areas"].features[0]
    assert area.geometry.area == pytest.approx(550.0 * 80.0, rel=0.01)


def test_runouts_are_points_for_each_quantile() -> None:
    layers = by_name(hazard_layers([drawn()], [bounds_row()], []))
    places = {
        (name, f.attributes["quantile"]): f
        for name in ("design_runouts", "volume_runouts")
        for f in layers[name].features
    }
    assert {key: f.attributes["x_m"] for key, f in places.items()} == {
        ("volume_runouts", "q05"): 700.0,
        ("volume_runouts", "q50"): 750.0,
        ("design_runouts", "q05"): 800.0,
        ("design_runouts", "q50"): 850.0,
        ("design_runouts", "q95"): 930.5,
    }
    for feature in places.values():
        on_line = shapely.LineString(feature.line.xy).project(feature.geometry)
        assert on_line == pytest.approx(feature.attributes["x_m"], abs=1e-6)
    last = places["design_runouts", "q95"]
    point = last.attributes
    assert (point["x_q05_m"], point["x_q95_m"], point["interval"]) == (800.0, 930.5, "uncertainty")
    assert (point["farthest_record_x_m"], point["records_beyond"]) == (900.0, 1)
    assert point["elevation_m"] == pytest.approx(np.interp(930.5, last.line.x, last.line.y))


def test_no_areas_without_a_width_and_no_design_for_a_volume() -> None:
    for width in (None, "wide", 0.0):
        layers = by_name(hazard_layers([drawn(width=width)], [bounds_row(period=None)], [zones()]))
        assert "zone_areas" not in layers
        assert "design_runouts" not in layers
        assert layers["volume_runouts"].features


def test_paths_in_several_systems_have_layers_of_their_own() -> None:
    both = [drawn("P"), drawn("Q", crs="EPSG:32632")]
    layers = by_name(hazard_layers(both, [bounds_row("P")], []))
    assert {name: layer.code for name, layer in layers.items() if layer.topic == "paths"} == {
        "paths_31287": "EPSG:31287",
        "paths_32632": "EPSG:32632",
    }
    assert layers["design_runouts"].code == "EPSG:31287"


@pytest.fixture
def line() -> PathLine:
    """Give the line of a profile."""
    made = path_line(profile())
    assert isinstance(made, PathLine)
    return made


def test_places_lie_on_the_line(line: PathLine) -> None:
    for x in (0.0, 333.3, 500.0, 777.7, 1000.0):
        point = line.at(x)
        assert point is not None
        whole = shapely.LineString(line.xy)
        assert whole.distance(point) < 1e-6
        assert whole.project(point) == pytest.approx(x, abs=1e-6)
    assert (line.at(-0.1), line.at(1000.1)) == (None, None)


def test_pieces_keep_the_corners_between_their_ends(line: PathLine) -> None:
    piece = line.between(410.0, 610.0)
    assert piece is not None
    assert piece.length == pytest.approx(200.0)
    assert piece.distance(shapely.Point(WEST, NORTH - 500.0)) < 1e-9
    assert piece.coords[-1] == pytest.approx((WEST + 66.0, NORTH - 588.0))
    rest = line.between(990.0, 1500.0)
    assert rest is not None
    assert rest.length == pytest.approx(10.0)
    assert (line.between(600.0, 600.0), line.between(1100.0, 1200.0)) == (None, None)


def test_a_strip_has_the_width_and_ends_where_the_piece_ends(line: PathLine) -> None:
    piece = line.between(100.0, 300.0)
    strip = line.strip(piece, 80.0)
    expected = shapely.box(WEST - 40.0, NORTH - 300.0, WEST + 40.0, NORTH - 100.0)
    assert strip.symmetric_difference(expected).area < 1e-6


def test_degrees() -> None:
    lat = np.linspace(47.0, 46.99, 21)
    bare = replace(profile(), easting_m=None, northing_m=None, crs=None)
    made = path_line(replace(bare, lon=np.full(21, 11.0), lat=lat))
    assert isinstance(made, PathLine)
    assert made.code == "EPSG:4326"
    piece = made.between(250.0, 750.0)
    assert piece is not None
    area, _ = Geod(ellps="WGS84").geometry_area_perimeter(made.strip(piece, 100.0))
    assert abs(area) == pytest.approx(100.0 * 0.005 * 111_170.0, rel=2e-3)


def test_what_the_coordinates_lack() -> None:
    assert path_line(profile(crs=None)) == "coordinates without a crs"
    assert path_line(profile(crs="Gauß")) == "unknown crs 'Gauß'"
    assert path_line(replace(profile(), easting_m=None, northing_m=None)) == "no coordinates"
    made = path_line(profile(crs="epsg:31287"))
    assert isinstance(made, PathLine)
    assert made.code == CODE
