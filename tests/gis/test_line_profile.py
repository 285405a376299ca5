"""Profiles of lines on a terrain model."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import rasterio
import shapely
from pyproj import CRS, Geod

from avahazard.gis.line_profile import LineFault, line_profile
from avahazard.gis.systems import WGS84, moved
from avahazard.gis.terrain_model import TerrainModel, open_terrain
from tests.gis.surface import BOTTOM, CODE, NORTH, TOP, WEST, surface, write_dem

SYSTEM = CRS(CODE)
CORNER = (WEST + 900.0, NORTH - 700.0)
LINE = shapely.LineString([TOP, CORNER, BOTTOM])


@pytest.fixture(scope="module")
def dem(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a terrain model of the surface, with a gap off the lines."""
    return write_dem(tmp_path_factory.mktemp("dem") / "dem.tif", holes=((60, 120),))


@pytest.fixture
def terrain(dem: Path) -> Iterator[TerrainModel]:
    """Give the model, open."""
    with open_terrain(dem) as model:
        yield model


def test_the_profile_is_that_of_the_surface(terrain: TerrainModel) -> None:
    profile = line_profile("P", LINE, SYSTEM, terrain)
    assert np.abs(profile.y - surface(profile.easting, profile.northing)).max() < 0.1
    # The surface along the line by itself: distances from the top, corner included.
    first = np.hypot(*np.subtract(CORNER, TOP))
    whole = first + np.hypot(*np.subtract(BOTTOM, CORNER))
    assert profile.x[0] == 0.0
    assert profile.x[-1] == pytest.approx(whole, abs=1e-6)
    part = np.clip(profile.x / first, 0.0, 1.0)[:, None]
    rest = np.clip((profile.x - first) / (whole - first), 0.0, 1.0)[:, None]
    xy = np.array(TOP) + part * np.subtract(CORNER, TOP) + rest * np.subtract(BOTTOM, CORNER)
    np.testing.assert_allclose(profile.y, surface(xy[:, 0], xy[:, 1]), atol=0.1)
    assert (profile.crs, profile.cover, profile.terrain.path_id) == (CODE, None, "P")
    assert np.diff(profile.x).max() <= 10.0


@pytest.mark.parametrize("code", ["EPSG:4326", "EPSG:32632", "EPSG:3857"])
def test_a_line_in_another_system_gives_the_same_profile(terrain: TerrainModel, code: str) -> None:
    corners = moved(shapely.get_coordinates(LINE), SYSTEM, CRS(code))
    expected = line_profile("P", LINE, SYSTEM, terrain)
    found = line_profile("P", shapely.LineString(corners), CRS(code), terrain)
    assert found.crs == CODE
    np.testing.assert_allclose(found.x, expected.x, atol=0.01)
    np.testing.assert_allclose(found.y, expected.y, atol=0.01)


@pytest.mark.parametrize("code", ["EPSG:4326", "EPSG:3857"])
def test_a_model_in_degrees_or_stretched_is_measured_on_the_ground(
    tmp_path: Path, code: str
) -> None:
    step = 10.0 if code == "EPSG:3857" else 1e-4
    west, north = moved(np.array([[WEST, NORTH]]), SYSTEM, CRS(code))[0]
    transform = (step, 0.0, west, 0.0, -step, north)
    file = write_dem(tmp_path / "dem.tif", crs=code, transform=transform)
    lonlat = moved(np.array([[west, north]]) + step * np.array([[20, -20], [70, -120]]),
                   CRS(code), WGS84)  # fmt: skip
    with open_terrain(file) as terrain:
        found = line_profile("P", shapely.LineString(lonlat), WGS84, terrain)
    assert found.crs == "EPSG:32632"
    ground = Geod(ellps="WGS84").inv(*lonlat[0], *lonlat[1])[2]
    assert found.x[-1] == pytest.approx(ground, rel=1e-3)


def test_points_are_50_to_400_and_corners_are_kept_while_they_are_few(
    terrain: TerrainModel, tmp_path: Path
) -> None:
    short = line_profile("P", shapely.LineString([TOP, np.add(TOP, (0, -100))]), SYSTEM, terrain)
    assert len(short.x) == 51
    with open_terrain(write_dem(tmp_path / "fine.tif", 1.5, 1000, 1000)) as fine:
        long = line_profile("P", LINE, SYSTEM, fine)
    assert 401 <= len(long.x) <= 403
    assert np.hypot(long.easting - CORNER[0], long.northing - CORNER[1]).min() < 1e-6
    walked = shapely.LineString(np.linspace(TOP, BOTTOM, 3000))
    many = line_profile("P", walked, SYSTEM, terrain)
    assert len(many.x) == 136
    assert many.x[-1] == pytest.approx(walked.length)


def test_one_part_is_a_line_and_a_point_twice_is_one(terrain: TerrainModel) -> None:
    twice = shapely.MultiLineString([[TOP, TOP, CORNER, BOTTOM, BOTTOM]])
    found = line_profile("P", twice, SYSTEM, terrain)
    np.testing.assert_array_equal(found.y, line_profile("P", LINE, SYSTEM, terrain).y)


@pytest.mark.parametrize(
    ("geometry", "value", "accepted"),
    [
        (None, "no geometry", "a line"),
        (shapely.LineString(), "no geometry", "a line"),
        (shapely.Point(TOP), "a Point", "a line"),
        (shapely.LineString([TOP, TOP]), "one point", "at least 2"),
        (shapely.MultiLineString([[TOP, CORNER], [CORNER, BOTTOM]]), "2 parts", "join"),
        (LINE.reverse(), "starts at", "from the top"),
        (shapely.LineString([TOP, np.add(TOP, (800, -400))]),
         "at 557 m from its top (256498 E", "edge"),
        (shapely.LineString([(WEST + 1205, NORTH - 400), (WEST + 1205, NORTH - 900)]),
         "no elevation", "missing"),
        (shapely.LineString([(11.0, 47.1), (11.0, 47.0)]), "nowhere on", "MGI / Austria Lambert"),
    ],
)  # fmt: skip
def test_lines_that_cannot_be_taken(
    terrain: TerrainModel, geometry: shapely.Geometry | None, value: str, accepted: str
) -> None:
    with pytest.raises(LineFault) as caught:
        line_profile("P", geometry, SYSTEM, terrain)
    assert value in caught.value.value
    assert accepted in caught.value.accepted


def test_map_metres_said_to_be_degrees(terrain: TerrainModel) -> None:
    with pytest.raises(LineFault, match="outside WGS 84"):
        line_profile("P", LINE, WGS84, terrain)


def test_a_mirrored_valley_has_the_same_profile(dem: Path, tmp_path: Path) -> None:
    mirrored = tmp_path / "mirrored.tif"
    with rasterio.open(dem) as source:
        values, profile = source.read(1)[:, ::-1], source.profile
        middle = 0.5 * (source.bounds.left + source.bounds.right)
        with rasterio.open(mirrored, "w", **profile) as target:
            target.write(values, 1)
    other_side = shapely.transform(
        LINE, lambda xy: np.column_stack([2 * middle - xy[:, 0], xy[:, 1]])
    )
    with open_terrain(dem) as here, open_terrain(mirrored) as there:
        first = line_profile("P", LINE, SYSTEM, here)
        second = line_profile("P", other_side, SYSTEM, there)
    np.testing.assert_allclose(second.x, first.x, atol=1e-6)
    np.testing.assert_allclose(second.y, first.y, atol=1e-3)


@pytest.mark.parametrize("cell", [np.nan, np.inf, 0.0])
def test_a_model_without_cells_under_the_line(
    terrain: TerrainModel, cell: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(TerrainModel, "cell_size", lambda *_: cell)
    with pytest.raises(LineFault, match="no cells"):
        line_profile("P", LINE, SYSTEM, terrain)
