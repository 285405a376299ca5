"""Paths on the map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from pyproj import Geod

from avahazard.gis.path_line import PathLine, path_line
from tests.gis.results import profile
from tests.gis.surface import CODE, NORTH, WEST


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
        assert line.whole.distance(point) < 1e-6
        assert line.whole.project(point) == pytest.approx(x, abs=1e-6)
    assert (line.at(-0.1), line.at(1000.1)) == (None, None)
    assert line.elevation(500.0) == pytest.approx(2000.0 - 400.0 + 75.0)


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
