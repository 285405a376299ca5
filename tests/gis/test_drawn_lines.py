"""Files of lines as rows of paths and profiles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from avahazard.gis.drawn_lines import read_drawn
from avahazard.records.errors import AvahazardError
from avahazard.records.table import Table
from tests.gis.surface import BOTTOM, CODE, NORTH, TOP, WEST, write_dem, write_lines

LINE = shapely.LineString([TOP, BOTTOM])


def rows(table: Table) -> list[dict[str, str]]:
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
        {
            "path_id": "P",
            "release_elevation_m": "2200",
            "observed_from": "1950",
            "snow_fence": "a",
        },
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
