"""A database filled from files, lines beside tables, and a full check of it."""

from __future__ import annotations

import gc
import json
from dataclasses import astuple
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import shapely
from sqlalchemy import text

from avahazard import gis
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.results.files import Import
from avahazard.store.records import load_records, load_terrain
from avahazard.store.session import reading, writing
from avahazard.store.tables import DrawChunkTable
from avahazard.workflow.database import check, import_files
from avahazard.workflow.requests import ImportRequest
from tests.gis.surface import BOTTOM, TOP, surface, write_dem, write_lines


def test_a_full_check_gives_the_draws_that_are_stored(snow_database: str) -> None:
    (found,) = check(snow_database, full=True).recomputed or ()
    assert (found.model, found.identical, found.why_not) == ("base", True, None)
    # An edit that brings its own checksum along passes every check but that of the sampler.
    with writing(snow_database) as session:
        row = session.get(DrawChunkTable, (1, "a", 0))
        assert row is not None
        data = bytearray(row.data)
        data[0] ^= 1
        row.data = bytes(data)
        row.sha256 = row.digest()
    assert check(snow_database).whole
    found_again = check(snow_database, full=True)
    assert not found_again.whole
    assert "base calibrated again has other draws" in found_again.problems[0]


def test_what_cannot_be_done_again_says_why(snow_database: str) -> None:
    with writing(snow_database) as session:
        session.execute(text("UPDATE events SET volume_m3 = 1.01 * volume_m3"))
    checked = check(snow_database, full=True)
    (found,) = checked.recomputed or ()
    assert checked.whole
    assert found.identical is None
    assert "records have changed" in str(found.why_not)
    assert json.loads(json.dumps(checked.to_dict()))["recomputed"][0]["model"] == "base"


LINE = shapely.LineString([TOP, BOTTOM])
EVENTS = "event_id,path_id,runout_elevation_m,volume_m3\na,P,1700,5000\n"


@pytest.fixture(scope="module")
def maps(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Give a file of lines and a terrain model."""
    folder = tmp_path_factory.mktemp("maps")
    columns = {"path_id": ["P"], "section": ["open"], "width_m": [80.0]}
    lines = write_lines(folder / "lines.gpkg", [LINE], columns)
    return lines, write_dem(folder / "dem.tif")


def counts(found: Import) -> dict[str, tuple[int, ...]]:
    """New, unchanged and updated, of paths and profiles."""
    kinds = ("paths", "profiles", "events")
    return {kind: astuple(getattr(found.records, kind)) for kind in kinds}


def test_lines_and_events_in_one_call(
    maps: tuple[Path, Path], database: str, tmp_path: Path
) -> None:
    lines, dem = maps
    events = tmp_path / "events.csv"
    events.write_text(EVENTS)
    for once in ((1, 0, 0), (0, 1, 0)):
        done = import_files(database, [events, lines], ImportRequest(dem=dem))
        assert counts(done) == dict.fromkeys(("paths", "profiles", "events"), once)
    assert done.files == (str(events), str(lines))
    with reading(database) as session:
        records, crop = load_records(session), load_terrain(session, "P")
    assert (records.paths[0].section, records.paths[0].covariates) == ("open", {"width_m": 80.0})
    (profile,) = records.profiles
    assert (len(profile.x_m), profile.crs) == (136, "EPSG:31287")
    assert profile.easting_m is not None
    assert profile.northing_m is not None
    off = profile.y_m - surface(profile.easting_m, profile.northing_m)
    assert np.abs(off).max() < 0.1
    assert crop is not None


def test_a_line_that_moved_needs_update(
    maps: tuple[Path, Path], database: str, tmp_path: Path
) -> None:
    lines, dem = maps
    import_files(database, [lines], ImportRequest(dem=dem))
    columns = {"path_id": ["P"], "section": ["open"], "width_m": [80.0]}
    moved = shapely.LineString([TOP, np.add(BOTTOM, (30.0, 0.0))])
    other = write_lines(tmp_path / "other.gpkg", [moved], columns)
    with pytest.raises(RejectedRows) as caught:
        import_files(database, [other], ImportRequest(dem=dem))
    assert "--update" in caught.value.problems[0].accepted
    with reading(database) as session:
        before = load_terrain(session, "P")
    done = import_files(database, [other], ImportRequest(dem=dem, update=True))
    assert counts(done)["profiles"] == (0, 0, 1)
    with reading(database) as session:
        after = load_terrain(session, "P")
    assert before is not None
    assert after is not None
    assert before.elevation_m.shape != after.elevation_m.shape


def test_the_ground_goes_with_the_profile_that_it_was_for(
    maps: tuple[Path, Path], database: str, tmp_path: Path
) -> None:
    import_files(database, [maps[0]], ImportRequest(dem=maps[1]))
    file = tmp_path / "profiles.csv"
    file.write_text("path_id,x_m,y_m\n" + "".join(f"P,{i},{9 - i}\n" for i in range(6)))
    import_files(database, [file], ImportRequest(update=True))
    with reading(database) as session:
        assert load_terrain(session, "P") is None


def test_a_bare_line_gives_a_profile_to_a_path_of_a_table(
    maps: tuple[Path, Path], database: str, tmp_path: Path
) -> None:
    paths = tmp_path / "paths.csv"
    paths.write_text("path_id,section\nP,open\n")
    lines = write_lines(tmp_path / "lines.gpkg", [LINE], {"path_id": ["P"], "name": [None]})
    done = import_files(database, [paths, lines], ImportRequest(dem=maps[1]))
    assert counts(done)["paths"] == (1, 0, 0)
    assert counts(import_files(database, [lines], ImportRequest(dem=maps[1])))["profiles"] == (
        0,
        1,
        0,
    )
    with reading(database) as session:
        assert load_records(session).paths[0].section == "open"


def test_nothing_is_stored_when_a_line_or_a_row_is_wrong(
    maps: tuple[Path, Path], database: str, tmp_path: Path
) -> None:
    columns = {"path_id": ["up", "P", "P"], "section": ["wide", "open", "open"]}
    lines = write_lines(tmp_path / "lines.gpkg", [LINE.reverse(), LINE, LINE], columns)
    events = tmp_path / "events.csv"
    # A path whose line was refused is still one that is named.
    events.write_text(EVENTS + "b,up,1700,5000\nc,none,1700,5000\n")
    with pytest.raises(RejectedRows) as caught:
        import_files(database, [lines, events], ImportRequest(dem=maps[1]))
    found = {(Path(p.file).name, p.line, p.column) for p in caught.value.problems}
    assert found == {
        ("lines.gpkg", 1, "geometry"),
        ("lines.gpkg", 1, "section"),
        ("lines.gpkg", 3, "path_id"),
        ("events.csv", 4, "path_id"),
    }
    done = import_files(database, [maps[0]], ImportRequest(dem=maps[1], dry_run=True))
    assert counts(done)["paths"] == (1, 0, 0)
    with reading(database) as session:
        assert load_records(session).paths == ()
        assert load_terrain(session, "P") is None


def test_lines_and_a_terrain_model_go_together(
    maps: tuple[Path, Path], database: str, tmp_path: Path
) -> None:
    lines, dem = maps
    with pytest.raises(AvahazardError, match="need a terrain model"):
        import_files(database, [lines])
    file = tmp_path / "events.csv"
    file.write_text(EVENTS)
    for options in ({"dem": dem}, {"land_cover": lines}):
        with pytest.raises(AvahazardError, match="no file of lines"):
            import_files(database, [file], ImportRequest(**options))


def test_missing_packages_are_named_with_the_command_that_installs_them(
    maps: tuple[Path, Path], database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        gis, "find_spec", lambda name: None if name == "pyogrio" else find_spec(name)
    )
    with pytest.raises(AvahazardError, match="pyogrio") as caught:
        import_files(database, [maps[0]], ImportRequest(dem=maps[1]))
    assert "pip install 'avahazard[gis]'" in caught.value.hint


def test_python_searches_for_rings_again_after_an_import(database: str, tmp_path: Path) -> None:
    events = tmp_path / "events.csv"
    events.write_text(EVENTS)
    with pytest.raises(AvahazardError):
        import_files(database, [events])  # of a path that is not there
    assert gc.isenabled()
