"""Files of lines as rows of paths and profiles."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import rasterio
import shapely
from pyproj import CRS, Geod

from avahazard.gis.drawn_lines import LineFault, avaframe_files, line_profile, read_drawn
from avahazard.gis.systems import WGS84, moved
from avahazard.gis.terrain_model import TerrainModel, open_terrain
from avahazard.records.errors import AvahazardError
from avahazard.records.table import FileTable
from tests.gis.surface import BOTTOM, CODE, NORTH, TOP, WEST, surface, write_dem, write_lines

LINE = shapely.LineString([TOP, BOTTOM])


def rows(table: FileTable) -> list[dict[str, str]]:
    """Give the cells of every row."""
    return [row for _, row in table.numbered()]


@pytest.fixture(scope="module")
def dem(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a terrain model."""
    return write_dem(tmp_path_factory.mktemp("dem") / "dem.tif")


def test_rows_carry_the_number_of_their_feature(tmp_path: Path, dem: Path) -> None:
    file = write_lines(
        tmp_path / "lines.gpkg",
        [LINE.reverse(), LINE, LINE],
        {"path_id": ["up", "P", None], "observed_from": [1900, 1950, 1960]},
    )
    (drawn,) = read_drawn([file], dem)
    assert drawn.paths.header == ("path_id", "observed_from")
    assert list(drawn.paths.numbered()) == [
        (1, {"path_id": "up", "observed_from": "1900"}),
        (2, {"path_id": "P", "observed_from": "1950"}),
        (3, {"observed_from": "1960"}),
    ]
    (problem,) = drawn.problems
    assert (problem.file, problem.line, problem.column) == (str(file), 1, "geometry")
    assert set(drawn.profiles.lines) == {2}
    first = rows(drawn.profiles)[0]
    assert first == {
        "path_id": "P",
        "x_m": "0.000",
        "y_m": first["y_m"],
        "easting_m": "256000.000",
        "northing_m": "381850.000",
        "crs": CODE,
    }
    assert [crop.path_id for crop in drawn.terrain] == ["P"]
    assert drawn.notes == ()


def test_a_name_serves_where_there_is_no_path_id(tmp_path: Path, dem: Path) -> None:
    file = write_lines(tmp_path / "lines.gpkg", [LINE], {"name": ["Long gully"]})
    (drawn,) = read_drawn([file], dem)
    assert rows(drawn.paths) == [{"path_id": "Long gully", "name": "Long gully"}]
    bare = write_lines(tmp_path / "bare.gpkg", [LINE], {"gully": ["x"]})
    with pytest.raises(AvahazardError, match="no attribute path_id, name or id") as caught:
        read_drawn([bare], dem)
    assert "gully" in caught.value.hint


@pytest.mark.parametrize(
    ("column", "row"),
    [
        ("NAME", {"path_id": "7", "name": "7"}),
        ("Name", {"path_id": "7", "name": "7"}),
        ("ID", {"path_id": "7"}),
        ("Path_ID", {"path_id": "7"}),
    ],
)
def test_attributes_in_other_spellings_name_the_paths(
    tmp_path: Path, dem: Path, column: str, row: dict[str, str]
) -> None:
    file = write_lines(tmp_path / "lines.gpkg", [LINE], {column: ["7"], "Section": ["open"]})
    (drawn,) = read_drawn([file], dem)
    assert rows(drawn.paths) == [{**row, "section": "open"}]


def test_a_terrain_model_without_a_system_takes_that_of_the_lines_and_says_so(
    tmp_path: Path, dem: Path
) -> None:
    bare = write_dem(tmp_path / "bare.asc", crs=None)
    file = write_lines(tmp_path / "lines.gpkg", [LINE], {"path_id": ["P"]})
    (known,) = read_drawn([file], dem)
    for crs, whose in ((None, "that of the lines"), (CODE, "that of --crs")):
        (drawn,) = read_drawn([file], bare, crs=crs)
        assert rows(drawn.profiles)[0]["crs"] == CODE
        assert rows(drawn.profiles) == rows(known.profiles)
        assert whose in drawn.notes[0]
    (drawn,) = read_drawn([file], dem, crs="EPSG:4326")
    assert drawn.notes == ()
    with pytest.raises(AvahazardError, match="no reference system nonsense"):
        read_drawn([file], bare, crs="nonsense")


def test_names_that_a_shapefile_cuts_are_known(tmp_path: Path, dem: Path) -> None:
    columns = {"path_id": ["P"], "release_el": [2200.0], "observed_f": [1950], "snow_fence": ["a"]}
    file = write_lines(tmp_path / "lines.shp", [LINE], columns)
    (drawn,) = read_drawn([file], dem)
    assert rows(drawn.paths) == [
        {"path_id": "P", "release_elevation_m": "2200", "observed_from": "1950", "snow_fence": "a"}
    ]


def test_land_cover_and_the_note_on_another_system(tmp_path: Path) -> None:
    degrees = (1e-4, 0.0, 11.0, 0.0, -1e-4, 47.0)
    dem = write_dem(tmp_path / "dem.tif", crs="EPSG:4326", transform=degrees)
    line = [(11.005, 46.999), (11.005, 46.99)]
    file = write_lines(tmp_path / "a.geojson", [line], {"path_id": ["P"]}, crs="EPSG:4326")
    forest = shapely.box(11.004, 46.98, 11.006, 46.9945)
    cover = write_lines(tmp_path / "cover.gpkg", [forest], {"land_cover": ["forest"]}, "EPSG:4326")
    (drawn,) = read_drawn([file], dem, cover)
    words = np.array([row["land_cover"] for row in rows(drawn.profiles)])
    assert set(words) == {"open", "forest"}
    assert (words == "forest").mean() == pytest.approx(0.5, abs=0.02)
    assert "EPSG:32632" in drawn.notes[0]
    assert drawn.terrain[0].crs == "EPSG:32632"


def test_every_file_is_read_on_the_one_model(tmp_path: Path, dem: Path) -> None:
    one = write_lines(tmp_path / "one.gpkg", [LINE], {"path_id": ["P"]})
    east = shapely.LineString([(WEST + 200, NORTH - 200), (WEST + 300, NORTH - 900)])
    two = write_lines(tmp_path / "two.gpkg", [east], {"path_id": ["Q"]})
    assert [rows(d.profiles)[0]["path_id"] for d in read_drawn([one, two], dem)] == ["P", "Q"]


SYSTEM = CRS(CODE)
CORNER = (WEST + 900.0, NORTH - 700.0)
LINE_LINE_PROFILE = shapely.LineString([TOP, CORNER, BOTTOM])


@pytest.fixture(scope="module")
def dem_of_line_profile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a terrain model of the surface, with a gap off the lines."""
    return write_dem(tmp_path_factory.mktemp("dem") / "dem.tif", holes=((60, 120),))


@pytest.fixture
def terrain(dem_of_line_profile: Path) -> Iterator[TerrainModel]:
    """Give the model, open."""
    with open_terrain(dem_of_line_profile) as model:
        yield model


def test_the_profile_is_that_of_the_surface(terrain: TerrainModel) -> None:
    profile, crop = line_profile("P", LINE_LINE_PROFILE, SYSTEM, terrain)
    assert np.abs(profile.y_m - surface(profile.easting_m, profile.northing_m)).max() < 0.1
    # The surface along the line by itself: distances from the top, corner included.
    first = np.hypot(*np.subtract(CORNER, TOP))
    whole = first + np.hypot(*np.subtract(BOTTOM, CORNER))
    assert profile.x_m[0] == 0.0
    assert profile.x_m[-1] == pytest.approx(whole, abs=1e-6)
    part = np.clip(profile.x_m / first, 0.0, 1.0)[:, None]
    rest = np.clip((profile.x_m - first) / (whole - first), 0.0, 1.0)[:, None]
    xy = np.array(TOP) + part * np.subtract(CORNER, TOP) + rest * np.subtract(BOTTOM, CORNER)
    np.testing.assert_allclose(profile.y_m, surface(xy[:, 0], xy[:, 1]), atol=0.1)
    assert (profile.crs, profile.land_cover, crop.path_id) == (CODE, None, "P")
    assert np.diff(profile.x_m).max() <= 10.0


@pytest.mark.parametrize("code", ["EPSG:4326", "EPSG:32632", "EPSG:3857"])
def test_a_line_in_another_system_gives_the_same_profile(terrain: TerrainModel, code: str) -> None:
    corners = moved(shapely.get_coordinates(LINE_LINE_PROFILE), SYSTEM, CRS(code))
    expected, _ = line_profile("P", LINE_LINE_PROFILE, SYSTEM, terrain)
    found, _ = line_profile("P", shapely.LineString(corners), CRS(code), terrain)
    assert found.crs == CODE
    np.testing.assert_allclose(found.x_m, expected.x_m, atol=0.01)
    np.testing.assert_allclose(found.y_m, expected.y_m, atol=0.01)


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
        found, _ = line_profile("P", shapely.LineString(lonlat), WGS84, terrain)
    assert found.crs == "EPSG:32632"
    ground = Geod(ellps="WGS84").inv(*lonlat[0], *lonlat[1])[2]
    assert found.x_m[-1] == pytest.approx(ground, rel=1e-3)


def test_points_are_50_to_400_and_corners_are_kept_while_they_are_few(
    terrain: TerrainModel, tmp_path: Path
) -> None:
    short, _ = line_profile("P", shapely.LineString([TOP, np.add(TOP, (0, -100))]), SYSTEM, terrain)
    assert len(short.x_m) == 51
    with open_terrain(write_dem(tmp_path / "fine.tif", 1.5, 1000, 1000)) as fine:
        long, _ = line_profile("P", LINE_LINE_PROFILE, SYSTEM, fine)
    assert 401 <= len(long.x_m) <= 403
    away = np.subtract(long.easting_m, CORNER[0]), np.subtract(long.northing_m, CORNER[1])
    assert np.hypot(*away).min() < 1e-6
    walked = shapely.LineString(np.linspace(TOP, BOTTOM, 3000))
    many, _ = line_profile("P", walked, SYSTEM, terrain)
    assert len(many.x_m) == 136
    assert many.x_m[-1] == pytest.approx(walked.length)


def test_one_part_is_a_line_and_a_point_twice_is_one(terrain: TerrainModel) -> None:
    twice = shapely.MultiLineString([[TOP, TOP, CORNER, BOTTOM, BOTTOM]])
    found, _ = line_profile("P", twice, SYSTEM, terrain)
    expected, _ = line_profile("P", LINE_LINE_PROFILE, SYSTEM, terrain)
    np.testing.assert_array_equal(found.y_m, expected.y_m)


@pytest.mark.parametrize(
    ("geometry", "value", "accepted"),
    [
        (None, "no geometry", "a line"),
        (shapely.LineString(), "no geometry", "a line"),
        (shapely.Point(TOP), "a Point", "a line"),
        (shapely.LineString([TOP, TOP]), "one point", "at least 2"),
        (shapely.MultiLineString([[TOP, CORNER], [CORNER, BOTTOM]]), "2 parts", "join"),
        (LINE_LINE_PROFILE.reverse(), "starts at", "from the top"),
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
    assert value in caught.value.args[0]
    assert accepted in caught.value.args[1]


def test_map_metres_said_to_be_degrees(terrain: TerrainModel) -> None:
    with pytest.raises(LineFault, match="outside WGS 84"):
        line_profile("P", LINE_LINE_PROFILE, WGS84, terrain)


def test_a_mirrored_valley_has_the_same_profile(dem_of_line_profile: Path, tmp_path: Path) -> None:
    mirrored = tmp_path / "mirrored.tif"
    with rasterio.open(dem_of_line_profile) as source:
        values, profile = source.read(1)[:, ::-1], source.profile
        middle = 0.5 * (source.bounds.left + source.bounds.right)
        with rasterio.open(mirrored, "w", **profile) as target:
            target.write(values, 1)
    other_side = shapely.transform(
        LINE_LINE_PROFILE, lambda xy: np.column_stack([2 * middle - xy[:, 0], xy[:, 1]])
    )
    with open_terrain(dem_of_line_profile) as here, open_terrain(mirrored) as there:
        first, _ = line_profile("P", LINE_LINE_PROFILE, SYSTEM, here)
        second, _ = line_profile("P", other_side, SYSTEM, there)
    np.testing.assert_allclose(second.x_m, first.x_m, atol=1e-6)
    np.testing.assert_allclose(second.y_m, first.y_m, atol=1e-3)


@pytest.mark.parametrize("cell", [np.nan, np.inf, 0.0])
def test_a_model_without_cells_under_the_line(
    terrain: TerrainModel, cell: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(TerrainModel, "cell_size", lambda *_: cell)
    with pytest.raises(LineFault, match="no cells"):
        line_profile("P", LINE_LINE_PROFILE, SYSTEM, terrain)


def avaframe_folder(folder: Path, release: bool = True) -> Path:
    """Write a folder as AvaFrame has it."""
    (folder / "Inputs" / "LINES").mkdir(parents=True)
    (folder / "Inputs" / "REL").mkdir()
    write_dem(folder / "Inputs" / "dem.asc", crs=None)
    write_lines(folder / "Inputs" / "LINES" / "path_aimec.shp", [LINE], {"name": ["p"]})
    write_lines(folder / "Inputs" / "LINES" / "splitAB.shp", [LINE], {"name": ["q"]})
    if release:
        area = shapely.box(TOP[0] - 400.0, TOP[1] - 400.0, TOP[0] + 50.0, TOP[1] - 100.0)
        write_lines(folder / "Inputs" / "REL" / "rel.shp", [area], {"name": ["r"]})
    return folder


def test_folders_of_avaframe(tmp_path: Path) -> None:
    path, dem, releases = avaframe_files(avaframe_folder(tmp_path / "avaTest"))
    (drawn,) = read_drawn([path], dem, releases=releases, only="avaTest")
    assert not drawn.problems
    ((_, row),) = drawn.paths.numbered()
    assert row["path_id"] == "avaTest"
    middle = TOP[1] - 250.0
    share = (TOP[1] - middle) / (TOP[1] - BOTTOM[1])
    there = surface(TOP[0] + share * (BOTTOM[0] - TOP[0]), middle)
    assert float(row["release_elevation_m"]) == pytest.approx(there, abs=8.0)
    none, *_ = read_drawn([path], dem, only="avaTest")
    assert list(none.paths.numbered()) == []
    (tmp_path / "avaTest" / "Inputs" / "other.tif").touch()
    with pytest.raises(AvahazardError, match=r"one terrain model in Inputs.*dem\.asc, other\.tif"):
        avaframe_files(tmp_path / "avaTest")
