"""A column that a file lacks keeps its stored values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from avahazard.records.collection import Records
from avahazard.records.merge import merge_records
from avahazard.records.reading import read_files, read_records

Write = Callable[[str, str], Path]

PATHS = "path_id,name,section,aspect\nP,Pra,open,45\n"
PROFILES = "path_id,x_m,y_m,elevation_sigma_m,land_cover\n" + "".join(
    f"P,{100 * i},{1000 - 90 * i},2,open\n" for i in range(6)
)
EVENTS = (
    "event_id,path_id,date,runout_x_m,volume_m3,deposit_length_m,deposit_width_m,"
    "deposit_thickness_m,snow_type\na,P,1850,300,,100,20,3,wet\nb,P,1990,310,9000,,,,dry\n"
)


def stored(write: Write) -> Records:
    """Read the whole records once, and remove the files."""
    for name, text in (("paths", PATHS), ("profiles", PROFILES), ("events", EVENTS)):
        folder = write(f"{name}.csv", text).parent
    records = read_records([folder])
    for file in folder.iterdir():
        file.unlink()
    return records


def updated(write: Write, known: Records, name: str, text: str, update: bool = True) -> Records:
    """Return what an update by this file would write."""
    file = write(name, text)
    intake = read_files([file], known)
    merge = merge_records(intake, known, update=update)
    file.unlink()
    assert intake.problems == []
    return merge.write


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
