"""Files read, checked and made into records."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError, RejectedRows, RowProblem
from avahazard.records.intake import merge_records
from avahazard.records.reading import find_files, read_files, read_records

Write = Callable[[str, str], Path]

PROFILE = "path_id,x_m,y_m\n" + "".join(f"P,{100 * i},{1000 - 90 * i}\n" for i in range(6))
EVENTS = "event_id,path_id,runout_elevation_m"


def problems(*files: Path, known: Records | None = None) -> list[RowProblem]:
    """Return what is wrong with `files`."""
    return read_files(files, known or Records()).problems


def test_a_full_set_of_files(write: Write) -> None:
    write(
        "paths.csv",
        "path_id,name,location,orientation,section,catchment_ha,release_elevation_m,"
        "observed_from,observed_to,observed_below_m,aspect,rock\n"
        "P,Gurraz,Savoie,N,open,12.5,990,1900,2000,700,45,gneiss\n",
    )
    write(
        "profiles.csv",
        "path_id,x_m,y_m,land_cover,easting_m,northing_m,crs,elevation_sigma_m\n"
        + "".join(
            f"P,{100 * i},{1000 - 90 * i},open,{i},{2 * i},EPSG:2154,{i}.5\n" for i in range(6)
        ),
    )
    write(
        "events.csv",
        "event_id,path_id,date,runout_elevation_m,runout_x_m,runout_sigma_m,left_profile,"
        "release_elevation_m,volume_m3,deposit_length_m,deposit_width_m,deposit_thickness_m,"
        "volume_rel_sigma,snow_type\n"
        "a,P,1850-02-13,600,,,0,,,100,20,3,,wet\n"
        "b,P,1940,,410,5,,980,5000,,,,0.2,\n"
        "c,P,,,,,1,,,40,,,,dry\n",
    )
    file = write(
        "velocities.csv", "event_id,x_m,elevation_m,speed_m_s,speed_sigma_m_s\na,50,955,30,\n"
    )
    records = read_records([file.parent])
    (path,) = records.paths
    assert (path.name, path.section, path.observed_to) == ("Gurraz", "open", 2000)
    assert path.covariates == {"aspect": 45.0, "rock": "gneiss"}
    (profile,) = records.profiles
    np.testing.assert_array_equal(profile.x_m, [0, 100, 200, 300, 400, 500])
    assert profile.land_cover == ("open",) * 6
    assert profile.crs == "EPSG:2154"
    assert profile.elevation_sigma_m is not None
    np.testing.assert_array_equal(profile.elevation_sigma_m, np.arange(6) + 0.5)
    assert profile.lon is None
    first, second, third = records.events
    assert (first.volume_m3, first.volume_rel_sigma, first.runout_sigma_m) == (3000, 0.5, 25)
    assert first.covariates == {"snow_type": "wet"}
    assert (second.volume_m3, second.volume_rel_sigma, second.runout_sigma_m) == (5000, 0.2, 5)
    assert (second.runout_x_m, second.covariates) == (410, {})
    assert (third.left_profile, third.deposit_length_m, third.volume_m3) == (True, 40, None)
    (speed,) = records.speeds
    assert (speed.x_m, speed.elevation_m, speed.speed_sigma_m_s) == (50, None, 3)


def test_a_profile_alone_makes_a_bare_path(write: Write) -> None:
    records = read_records([write("p.csv", PROFILE)])
    assert [p.path_id for p in records.paths] == ["P"]
    assert records.paths[0].name is None


def test_one_file_may_hold_events_with_and_without_a_path(write: Write) -> None:
    write("profiles.csv", PROFILE)
    file = write(
        "events.csv",
        "event_id,path_id,runout_x_m,left_profile,fall_height_m,runout_length_m\n"
        "a,P,300,0,,\nb,,,0,800,2000\nc,P,,1,,\n",
    )
    records = read_records([file.parent])
    assert [e.event_id for e in records.events] == ["a", "b", "c"]
    assert records.events[1].fall_height_m == 800
    assert records.events[1].path_id is None


@pytest.mark.parametrize(
    ("row", "column"),
    [
        ("a,P,800,1950-02-30,,,,,,", "date"),
        ("a,P,800,13.2.50,,,,,,", "date"),
        ("a,P,800,3/2/1950,,,,,,", "date"),
        ("a,P,800,0000,,,,,,", "date"),
        ("a,P,800,195O,,,,,,", "date"),
        ("a,P,nan,,,,,,,", "runout_elevation_m"),
        ("a,P,1_000,,,,,,,", "runout_elevation_m"),
        ('a,P,"1,800",,,,,,,', "runout_elevation_m"),
        ("a,P,,,,,,,,", "runout_x_m"),
        ("a,P,800,,-5,,,,,", "volume_m3"),
        ("a,P,800,,0,,,,,", "volume_m3"),
        ("a,P,800,,,0,,,,", "runout_sigma_m"),
        ("a,P,800,,,,2,,,", "left_profile"),
        ("a,P,800,,,,,100,20,", "deposit_thickness_m"),
        ("a,P,800,,,,,,20,", "deposit_length_m"),
        ("a,P,800,,,,,,,-1", "volume_rel_sigma"),
        ("a,,800,,,,,,,", "path_id"),
        (",P,800,,,,,,,", "event_id"),
        ("a,Z,800,,,,,,,", "path_id"),
        ("a,P,100,,,,,,,", "runout_elevation_m"),
        ("a,P,1100,,,,,,,", "runout_elevation_m"),
    ],
)
def test_bad_events_are_named(write: Write, row: str, column: str) -> None:
    write("profiles.csv", PROFILE)
    file = write(
        "events.csv",
        f"{EVENTS},date,volume_m3,runout_sigma_m,left_profile,deposit_length_m,"
        f"deposit_width_m,volume_rel_sigma\nok,P,800,,,,,,,\n{row}\n",
    )
    found = problems(file.parent)
    assert [(p.file, p.line, p.column) for p in found] == [(str(file), 3, column)]
    assert found[0].accepted


@pytest.mark.parametrize(
    ("cells", "remedy"),
    [
        ("800,30/02/1978,10,1", "this day does not exist"),
        ("800,1978-02-30,10,1", "this day does not exist"),
        ("800,2999-01-01,10,1", "a date that is not in the future"),
        ("800-900,1978,10,1", 'range = "mean"'),
        ("800,1978,10-20,1", 'range = "geometric"'),
        ("800,1978,environ 5'000,1", "the number alone, such as 5'000"),
        ("800,1978,5000 m3,1", "the number alone, such as 5000"),
        ("800,1978,m3,1", "a row of units needs units = 4"),
        ("800,1978,selten,1", "unknown = ['selten'] in columns.toml"),
        ("k.A.,1978,10,1", "unknown = ['k.A.'] in columns.toml"),
        ("800,1978,10,ca. 4", "a number, as in most of the column"),
        ("800,1978,10,1e40", "a number of at most 1e+30"),
    ],
)
def test_what_would_be_accepted(write: Write, cells: str, remedy: str) -> None:
    write("profiles.csv", PROFILE)
    rows = f"a,P,800,1978,10,1\nb,P,800,1978,10,2\nc,P,{cells}\n"
    file = write("events.csv", f"{EVENTS},date,volume_m3,snow\n{rows}")
    (problem,) = problems(file.parent)
    assert problem.accepted.count("--unknown") < 2
    assert remedy in problem.accepted


@pytest.mark.parametrize(
    ("row", "column"),
    [
        ("P,1900,1899,open,1", "observed_from"),
        ("P,1900.5,,,", "observed_from"),
        ("P,,,gully,", "section"),
        ("P,,,,-3", "catchment_ha"),
        (f"{'P' * 201},,,,", "path_id"),
    ],
)
def test_bad_paths_are_named(write: Write, row: str, column: str) -> None:
    header = "path_id,observed_from,observed_to,section,catchment_ha"
    found = problems(write("paths.csv", f"{header}\n{row}\n"))
    assert [(p.line, p.column) for p in found] == [(2, column)]


@pytest.mark.parametrize(
    ("change", "line", "column"),
    [
        (("P,300,", "P,200,"), 5, "x_m"),
        (("P,0,1000", "P,0,500"), 7, "y_m"),
        (("P,300,730", "P,300,inf"), 5, "y_m"),
        (("P,300,730", "P,,730"), 5, "x_m"),
        (("P,400,640\nP,500,550\n", ""), 2, "path_id"),
    ],
)
def test_bad_profiles_are_named(
    write: Write, change: tuple[str, str], line: int, column: str
) -> None:
    found = problems(write("profiles.csv", PROFILE.replace(*change)))
    assert [(p.line, p.column) for p in found] == [(line, column)]


@pytest.mark.parametrize(
    ("columns", "cells", "wrong", "line", "column"),
    [
        ("land_cover", "forest", "", 4, "land_cover"),
        ("easting_m,northing_m", "1,2", "1,", 4, "northing_m"),
        ("lon,lat", "7,45", ",", 4, "lon"),
        ("elevation_sigma_m", "2.5", "", 4, "elevation_sigma_m"),
        ("elevation_sigma_m", "2.5", "0", 4, "elevation_sigma_m"),
        ("lon,lat", "7,45", "7,91", 4, "lat"),
        ("easting_m,northing_m,crs", "1,2,A", "1,2,B", 4, "crs"),
    ],
)
def test_bad_points_are_named(
    write: Write, columns: str, cells: str, wrong: str, line: int, column: str
) -> None:
    rows = [f"P,{i},{10 - i},{wrong if i == 2 else cells}" for i in range(5)]
    text = "\n".join([f"path_id,x_m,y_m,{columns}", *rows])
    assert [(p.line, p.column) for p in problems(write("profiles.csv", text))] == [(line, column)]


@pytest.mark.parametrize(
    ("row", "column"),
    [
        ("e,,,5,1", "x_m"),
        ("e,100,,-5,1", "speed_m_s"),
        ("e,100,,5,0", "speed_sigma_m_s"),
        ("z,100,,5,1", "event_id"),
        ("e,501,,5,1", "x_m"),
        ("e,,300,5,1", "elevation_m"),
        ("e,200,,6,1", "x_m"),
    ],
)
def test_bad_speeds_are_named(write: Write, row: str, column: str) -> None:
    write("profiles.csv", PROFILE)
    write("events.csv", f"{EVENTS}\ne,P,800\n")
    header = "event_id,x_m,elevation_m,speed_m_s,speed_sigma_m_s"
    file = write("velocities.csv", f"{header}\ne,200,,5,1\n{row}\n")
    assert [(p.line, p.column) for p in problems(file.parent)] == [(3, column)]


def test_a_counter_slope_needs_the_distance(write: Write) -> None:
    write("profiles.csv", PROFILE + "P,600,600\n")
    file = write("events.csv", f"{EVENTS},runout_x_m\na,P,580,\nb,P,580,590\nc,P,640,\n")
    (problem,) = problems(file.parent)
    assert (problem.line, problem.column, problem.value) == (2, "runout_elevation_m", "580")
    assert "runout_x_m" in problem.accepted


def test_ids_stand_once(write: Write) -> None:
    write("profiles.csv", PROFILE)
    write("more.csv", PROFILE)
    write("paths.csv", "path_id\nP\nP \n")
    file = write("events.csv", f"{EVENTS}\na,P,wrong\na,P,800\n")
    found = problems(file.parent)
    assert [(Path(p.file).name, p.line, p.column) for p in found] == [
        ("events.csv", 2, "runout_elevation_m"),
        ("events.csv", 3, "event_id"),
        ("paths.csv", 3, "path_id"),
        ("profiles.csv", 2, "path_id"),
    ]


def test_a_refused_row_is_not_blamed_twice(write: Write) -> None:
    write("profiles.csv", PROFILE.replace("P,300,730", "P,300,no"))
    write("events.csv", f"{EVENTS}\na,P,no\n")
    file = write("velocities.csv", "event_id,x_m,speed_m_s\na,100,9\n")
    assert [(Path(p.file).name, p.line) for p in problems(file.parent)] == [
        ("events.csv", 2),
        ("profiles.csv", 5),
    ]


def test_rows_refer_to_stored_records(write: Write) -> None:
    known = read_records([write("profiles.csv", PROFILE)])
    file = write("events.csv", f"{EVENTS}\na,P,800\nb,P,300\n")
    assert [(p.line, p.column) for p in problems(file, known=known)] == [(3, "runout_elevation_m")]


def test_a_new_profile_is_held_against_stored_events(write: Write) -> None:
    write("profiles.csv", PROFILE)
    known = read_records([write("events.csv", f"{EVENTS}\na,P,560\n").parent])
    shorter = write("profiles.csv", PROFILE.replace("P,500,550", "P,500,620"))
    (problem,) = problems(shorter, known=known)
    assert (problem.file, problem.column, problem.value) == (
        "the database, event a",
        "runout_elevation_m",
        "560",
    )


def test_all_problems_come_in_one_error(write: Write) -> None:
    write("profiles.csv", PROFILE)
    file = write("events.csv", f"{EVENTS}\na,P,x\nb,Z,y\n")
    with pytest.raises(RejectedRows) as caught:
        read_records([file.parent])
    assert len(caught.value.problems) == 2
    assert caught.value.message.startswith("2 values")


def test_events_to_predict_may_lack_their_runout(write: Write) -> None:
    write("profiles.csv", PROFILE)
    file = write("events.csv", "event_id,path_id,volume_m3\na,P,5000\n")
    (event,) = read_records([file.parent], need_runout=False).events
    assert event.runout_x_m is None
    assert event.runout_elevation_m is None


def test_unused_columns_are_said(write: Write) -> None:
    file = write("profiles.csv", PROFILE.replace("y_m\n", "y_m,cover\n").replace("0\n", "0,\n"))
    intake = read_files([file], Records())
    assert not intake.problems
    assert "cover" in intake.notes[0]


@pytest.mark.parametrize(
    ("folder", "counts"), [("avanodes", (4, 4, 4, 117)), ("tyrol-profiles", (9, 9, 0, 0))]
)
def test_real_files_are_read(
    shared_data: Path, folder: str, counts: tuple[int, int, int, int]
) -> None:
    found = read_records([shared_data / folder])
    assert (len(found.paths), len(found.profiles), len(found.events), len(found.speeds)) == counts


def test_real_rock_avalanches_lie_on_their_straight_lines(shared_data: Path) -> None:
    found = read_records([shared_data / "rock-avalanches-canada" / "events.csv"])
    assert len(found.events) == 49
    assert all(e.path_id is None and e.fall_height_m and e.volume_m3 for e in found.events)
    assert "Rubble Creek" in {e.event_id for e in found.events}
    assert isinstance(found.events[0].covariates["deposit_area_m2"], float)
    assert found.events[0].covariates["confinement"] == "Frontal"


@pytest.mark.parametrize(
    ("header", "column"),
    [
        ("volme_m3", "volme_m3"),
        ("volume", "volume"),
        ("volume_km3", "volume_km3"),
        ("Date,date", "Date"),
        ("Volume_m3,VOLUME_M3", ""),
    ],
)
def test_near_misses_of_columns_are_refused(write: Write, header: str, column: str) -> None:
    write("profiles.csv", PROFILE)
    n = header.count(",") + 1
    file = write("events.csv", f"{EVENTS},{header}\na,P,800{',1950' * n}\n")
    (problem,) = problems(file.parent)
    assert (problem.line, problem.column) == (1, column)


def test_other_spellings_are_the_known_columns(write: Write) -> None:
    write("profiles.csv", PROFILE)
    write("paths.csv", "path_id,OBSERVED_FROM,Aspect\nP,1900,30\n")
    file = write("events.csv", f"{EVENTS},Volume_m3,Date\na,P,800,5000,1950\n")
    intake = read_files([file.parent], Records())
    (event,) = intake.records.events
    assert (event.volume_m3, event.date, event.covariates) == (5000, "1950", {})
    assert intake.records.paths[0].observed_from == 1900
    assert any("Volume_m3 is volume_m3, Date is date" in line for line in intake.read)
    again = read_files([write("paths.csv", "path_id,aspect\nP,40\n")], intake.records)
    assert again.records.paths[0].covariates == {"Aspect": 40.0}


def test_a_profile_beyond_the_earth_is_refused_by_its_row_alone(write: Write) -> None:
    rows = "".join(f"P,{20 * k},{1e300 if k == 3 else 900 - 9 * k}\n" for k in range(12))
    paths = write("paths.csv", "path_id\nP\n")
    profiles = write("profiles.csv", f"path_id,x_m,y_m\n{rows}")
    events = write("events.csv", "event_id,path_id,runout_elevation_m\na,P,850\n")
    (problem,) = problems(paths, profiles, events)
    assert (problem.line, problem.column) == (5, "y_m")


def test_a_folder_stands_for_its_csv_files_each_once(tmp_path: Path) -> None:
    for name in ("b.csv", "a.CSV", "notes.txt"):
        (tmp_path / name).touch()
    assert find_files([tmp_path / "b.csv", tmp_path]) == [tmp_path / "b.csv", tmp_path / "a.CSV"]


def test_missing_source_and_empty_folder_are_said(tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="no file or folder"):
        find_files([tmp_path / "none.csv"])
    with pytest.raises(AvahazardError, match="holds no table"):
        find_files([tmp_path])


def test_a_folder_may_hold_workbooks_but_not_two_files_of_one_name(tmp_path: Path) -> None:
    for name in ("events.xlsx", "paths.csv", "~$events.xlsx", ".hidden.csv"):
        (tmp_path / name).touch()
    assert [f.name for f in find_files([tmp_path])] == ["events.xlsx", "paths.csv"]
    (tmp_path / "Events.csv").touch()
    with pytest.raises(AvahazardError, match=r"Events\.csv and events\.xlsx") as caught:
        find_files([tmp_path])
    assert "Name the file" in caught.value.hint


def test_old_spreadsheets_are_not_passed_over(tmp_path: Path) -> None:
    for name in ("events.numbers", "paths.csv"):
        (tmp_path / name).touch()
    with pytest.raises(AvahazardError, match=r"events\.numbers") as caught:
        find_files([tmp_path])
    assert ".xlsx" in caught.value.hint


PATHS = "path_id,name,section,aspect\nP,Pra,open,45\n"
PROFILES = "path_id,x_m,y_m,elevation_sigma_m,land_cover\n" + "".join(
    f"P,{100 * i},{1000 - 90 * i},2,open\n" for i in range(6)
)
EVENTS_WITH_DEPOSITS = (
    "event_id,path_id,date,runout_x_m,volume_m3,deposit_length_m,deposit_width_m,"
    "deposit_thickness_m,snow_type\na,P,1850,300,,100,20,3,wet\nb,P,1990,310,9000,,,,dry\n"
)


def stored(write: Write) -> Records:
    """Read the whole records once, and remove the files."""
    for name, text in (("paths", PATHS), ("profiles", PROFILES), ("events", EVENTS_WITH_DEPOSITS)):
        folder = write(f"{name}.csv", text).parent
    records = read_records([folder])
    for file in folder.iterdir():
        file.unlink()
    return records


def updated(write: Write, known: Records, name: str, text: str, update: bool = True) -> Records:
    """Return what an update by this file would write."""
    file = write(name, text)
    intake = read_files([file], known)
    new, _ = merge_records(intake, update=update)
    file.unlink()
    assert intake.problems == []
    return new


def test_a_file_with_fewer_columns_changes_only_those(write: Write) -> None:
    known = stored(write)
    (path,) = updated(write, known, "paths.csv", "path_id,name\nP,Prato\n").paths
    assert path == replace(known.paths[0], name="Prato")
    (event,) = updated(write, known, "events.csv", "event_id,path_id,volume_m3\nb,P,7000\n").events
    assert event == replace(known.events[1], volume_m3=7000.0)
    text = (
        PROFILES.replace(",land_cover", "").replace(",open", "").replace("P,100,910", "P,100,905")
    )
    (profile,) = updated(write, known, "profiles.csv", text).profiles
    assert profile.land_cover == ("open",) * 6
    assert profile.elevation_sigma_m is not None
    assert profile.y_m[1] == 905


def test_fewer_columns_are_no_contradiction(write: Write) -> None:
    known = stored(write)
    text = "event_id,path_id,runout_x_m\na,P,300\nb,P,310\n"
    assert updated(write, known, "events.csv", text, update=False) == Records()


def test_an_empty_cell_clears(write: Write) -> None:
    known = stored(write)
    text = "event_id,path_id,runout_x_m,snow_type,volume_m3\nb,P,310,,\n"
    (event,) = updated(write, known, "events.csv", text).events
    assert (event.covariates, event.volume_m3) == ({}, None)


def test_defaults_follow_what_they_stand_on(write: Write) -> None:
    known = stored(write)
    (event,) = updated(write, known, "events.csv", "event_id,path_id,date\na,P,1990\n").events
    assert (event.runout_sigma_m, event.volume_m3) == (10.0, 3000.0)
    text = "event_id,path_id,deposit_length_m\na,P,200\n"
    (event,) = updated(write, known, "events.csv", text).events
    assert event.volume_m3 == 6000.0


def test_points_elsewhere_lose_their_cover_with_a_note(write: Write) -> None:
    known = stored(write)
    text = "path_id,x_m,y_m\n" + "".join(f"P,{90 * i},{1000 - 90 * i}\n" for i in range(6))
    intake = read_files([write("profiles.csv", text)], known)
    assert intake.records.profiles[0].land_cover is None
    assert any("no land_cover" in note for note in intake.notes)


@pytest.mark.parametrize(
    ("given", "read"),
    [
        ("N NO O SO W", "N NE E SE W"),
        ("N E SO O", "N E SW W"),
        ("N NO O S", "N NO O S"),
        ("N E W O", "N E W O"),
        ("NØ V S", "NE W S"),
        ("ne Nord", "ne Nord"),
    ],
)
def test_the_directions_of_a_file_decide_on_their_language(
    write: Write, given: str, read: str
) -> None:
    rows = [f"p{k},{text}" for k, text in enumerate(given.split())]
    file = write("paths.csv", "\n".join(["path_id,orientation", *rows]))
    found = read_files([file], Records())
    assert " ".join(str(path.orientation) for path in found.records.paths) == read
    assert any("no direction" in note for note in found.notes) == (given == read)
