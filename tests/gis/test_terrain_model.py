"""Terrain models."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rasterio
from pyproj import CRS
from rasterio.transform import Affine
from scipy.interpolate import RegularGridInterpolator

from avahazard.arrays import Floats
from avahazard.gis.systems import WGS84, moved, system_code
from avahazard.gis.terrain_model import _has_cells, open_terrain
from avahazard.records.errors import AvahazardError
from tests.gis.surface import CODE, NORTH, WEST, surface, write_dem

PLACES = np.array([[WEST + 333.3, NORTH - 777.7], [WEST + 5.0, NORTH - 5.0], [WEST + 1491, NORTH]])


def bilinear(file: Path, xy: Floats) -> Floats:
    """Interpolate between all cell centres of a north-up model at once."""
    with rasterio.open(file) as source:
        cells = source.read(1).astype(float)
        a, _, west, _, e, north = source.transform[:6]
    east = west + (np.arange(cells.shape[1]) + 0.5) * a
    down = north + (np.arange(cells.shape[0]) + 0.5) * e
    grid = RegularGridInterpolator((-down, east), cells)
    return np.asarray(grid(np.column_stack([-xy[:, 1], xy[:, 0]])))


@pytest.mark.parametrize("name", ["dem.tif", "dem.asc"])
def test_elevations_lie_straight_between_cell_centres(tmp_path: Path, name: str) -> None:
    file = write_dem(tmp_path / name)
    rng = np.random.default_rng(1)
    xy = np.array([WEST, NORTH]) + rng.uniform([5, -1595], [1495, -5], (100, 2))
    with open_terrain(file) as terrain:
        assert terrain.holds(xy).all()
        np.testing.assert_allclose(terrain.elevations(xy), bilinear(file, xy), atol=1e-4)
        assert terrain.holds(PLACES).tolist() == [True, True, False]
        assert system_code(terrain.crs) == CODE


def test_a_turned_grid_and_one_of_whole_numbers_with_a_scale(tmp_path: Path) -> None:
    turn = Affine.translation(WEST, NORTH) @ Affine.rotation(30.0) @ Affine.scale(10.0, -10.0)
    column, row = np.meshgrid(np.arange(40) + 0.5, np.arange(50) + 0.5)
    east, north = turn @ (column, row)
    # A plane: straight lines between cells are the plane itself.
    plane = 1500.0 + 0.2 * (east - WEST) - 0.5 * (north - NORTH)
    file = tmp_path / "turned.tif"
    options = {"width": 40, "height": 50, "count": 1, "crs": CODE, "transform": turn}
    with rasterio.open(file, "w", driver="GTiff", dtype="int32", **options) as target:
        target.write(np.round((plane - 1000.0) * 1000.0).astype(np.int32), 1)
        target.scales, target.offsets = (0.001,), (1000.0,)
    xy = np.column_stack(turn @ (np.array([3.2, 17.9]), np.array([8.1, 40.4])))
    with open_terrain(file) as terrain:
        found = terrain.elevations(xy)
    expected = 1500.0 + 0.2 * (xy[:, 0] - WEST) - 0.5 * (xy[:, 1] - NORTH)
    np.testing.assert_allclose(found, expected, atol=2e-3)


@pytest.mark.parametrize("nodata", [-9999.0, None])
def test_a_gap_is_no_elevation_declared_or_not(tmp_path: Path, nodata: float | None) -> None:
    file = write_dem(tmp_path / "dem.tif", holes=((10, 20),), nodata=nodata)
    near = np.array([[WEST + 203.0, NORTH - 103.0], [WEST + 203.0, NORTH - 133.0]])
    with open_terrain(file) as terrain:
        assert np.isnan(terrain.elevations(near)).tolist() == [True, False]


@pytest.mark.parametrize("target", ["EPSG:31287", "EPSG:32632"])
@pytest.mark.parametrize("cell", [10.0, 2.0])
def test_the_ground_around_a_path(tmp_path: Path, target: str, cell: float) -> None:
    n = round(1500 / cell)
    file = write_dem(tmp_path / "dem.tif", cell, n, n)
    system = CRS(target)
    line = np.array([[WEST + 300.0, NORTH - 300.0], [WEST + 1100.0, NORTH - 1450.0]])
    with open_terrain(file) as terrain:
        crop = terrain.around("P", moved(line, CRS(CODE), system), system, target)
    assert (crop.path_id, crop.crs, crop.elevation_m.dtype) == ("P", target, np.float32)
    n_rows, n_columns = crop.elevation_m.shape
    assert max(n_rows, n_columns) <= 400
    east = crop.west_m + (np.arange(n_columns) + 0.5) * crop.cell_m
    north = crop.north_m - (np.arange(n_rows) + 0.5) * crop.cell_m
    centres = np.stack(np.meshgrid(east, north), axis=-1).reshape(-1, 2)
    there = moved(centres, system, CRS(CODE))
    off = crop.elevation_m.ravel() - surface(there[:, 0], there[:, 1])
    # What lies south of the model is not known; the path itself is.
    assert 0.0 < np.isnan(off).mean() < 0.2
    assert np.nanmax(np.abs(off)) < 1.5


def test_cells_of_degrees_have_a_size_in_metres(tmp_path: Path) -> None:
    second = 1.0 / 3600.0
    transform = Affine(second, 0.0, 11.0, 0.0, -second, 47.0)
    file = write_dem(tmp_path / "dem.tif", crs="EPSG:4326", transform=transform)
    with open_terrain(file) as terrain:
        utm = CRS("EPSG:32632")
        near = moved(np.array([[11.01, 46.99]]), WGS84, utm)[0]
        # 30.87 m to the south, 21.1 m to the east.
        assert terrain.cell_size(near, utm) == pytest.approx(25.5, abs=0.2)


def test_models_that_cannot_be_used(tmp_path: Path) -> None:
    words = tmp_path / "words.tif"
    words.write_text("no terrain")
    three = tmp_path / "picture.tif"
    options = {"width": 2, "height": 2, "count": 3, "crs": CODE, "dtype": "uint8"}
    with rasterio.open(three, "w", driver="GTiff", transform=Affine.scale(1, -1), **options):
        pass
    feet = write_dem(tmp_path / "feet.tif")
    with rasterio.open(feet, "r+") as source:
        source.units = ("ft",)
    bare = write_dem(tmp_path / "bare.asc", crs=None)
    for file, message, hint in (
        (tmp_path / "none.tif", "no file", "--dem"),
        (words, "cannot be read", ".asc"),
        (three, "3 bands", "one band"),
        (feet, "not in metres", "Convert"),
        (bare, "no reference system", "bare.prj"),
        (write_dem(tmp_path / "heights.tif", crs="EPSG:26912+6360"), "not in metres", "Convert"),
    ):
        with pytest.raises(AvahazardError, match=message) as caught, open_terrain(file):
            pass
        assert hint in caught.value.hint


def test_the_hint_for_a_model_without_a_system_helps(tmp_path: Path) -> None:
    file = write_dem(tmp_path / "dem.asc", crs=None)
    file.with_suffix(".prj").write_text(CRS(CODE).to_wkt("WKT1_ESRI"))
    with open_terrain(file) as terrain:
        assert system_code(terrain.crs) == CODE


@pytest.mark.parametrize("width", [0.0, np.nan, np.inf])
def test_cells_without_a_place_are_none(width: float) -> None:
    assert _has_cells(Affine(10.0, 0.0, WEST, 0.0, -10.0, NORTH))
    assert not _has_cells(Affine(width, 0.0, WEST, 0.0, -10.0, NORTH))
