"""Predictions of new events."""

from __future__ import annotations

import csv
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.workflow.calibrate import add, calibrate
from avahazard.workflow.compare import predict
from avahazard.workflow.database import import_files
from avahazard.workflow.path import run_block
from avahazard.workflow.requests import CalibrateRequest, RunoutRequest

Write = Any
NEW = "event_id,path_id,volume_m3\nsmall,P01,3000\nlarge,P01,400000\n"


def test_larger_avalanches_run_farther(snow_database: str, write: Write) -> None:
    found = predict(snow_database, "base", write("new.csv", NEW))
    small, large = found.events
    assert (small.event_id, small.path_id, small.coordinate) == (
        "small", "P01", "elevation"
    )  # fmt: skip
    assert small.q50_m > large.q50_m
    for row in found.events:
        assert row.q05_m < row.q50_m < row.q95_m
        assert row.q05_m < row.mean_m < row.q95_m
        assert 0.0 <= row.p_left_profile <= 1.0
    assert found.scores is None


def test_its_own_runout_only_scores(snow_database: str, write: Write) -> None:
    plain = predict(snow_database, "base", write("new.csv", NEW))
    elevation = plain.events[0].q50_m
    text = (
        "event_id,path_id,volume_m3,runout_elevation_m\n"
        f"small,P01,3000,{elevation:.1f}\nlarge,P01,400000,\n"
    )
    scored = predict(snow_database, "base", write("scored.csv", text))
    assert scored.events == plain.events
    assert scored.scores.runout.n == 1
    assert scored.scores.runout.coverage_50 == 1.0


def test_an_event_that_is_called_as_a_stored_one_is_no_less_new(
    snow_database: str, snow_world: Path, write: Write
) -> None:
    """It gets no volume, snow or runout from the record of that name."""
    stored = (snow_world / "world" / "events.csv").read_text().splitlines()[1].split(",")[0]
    plain = predict(snow_database, "base", write("new.csv", NEW))
    same_name = predict(snow_database, "base", write("named.csv", NEW.replace("small", stored)))
    assert same_name.scores is None
    named = [replace(row, event_id="small") for row in same_name.events[:1]]
    assert named == list(plain.events[:1])
    unknown = "event_id,path_id\nsmall,P01\n"
    without = predict(snow_database, "base", write("u.csv", unknown)).events[0]
    found = predict(snow_database, "base", write("v.csv", unknown.replace("small", stored)))
    assert found.events[0].q50_m == without.q50_m


def test_an_unsure_release_widens_what_has_no_runout(snow_database: str, write: Write) -> None:
    text = (
        "event_id,path_id,fall_height_m,volume_m3,release_sigma_m\n"
        "sure,P01,,3000,\nunsure,P01,,3000,80\nline,,1000,3000,\nloose,,1000,3000,300\n"
    )
    plain = predict(snow_database, "base", write("new.csv", NEW)).events[0]
    sure, unsure, line, loose = predict(snow_database, "base", write("release.csv", text)).events
    assert sure.mean_m == pytest.approx(plain.mean_m, abs=0.1 * plain.sd_m)
    assert unsure.sd_m != pytest.approx(sure.sd_m, rel=1e-6)
    assert unsure.sd_m == pytest.approx(sure.sd_m, rel=0.1)
    # L = H / μ: a fall that is off by 30 % is a length that is.
    share = np.hypot(line.sd_m / line.mean_m, 0.3 * np.hypot(1.0, line.sd_m / line.mean_m))
    assert loose.sd_m / loose.mean_m == pytest.approx(share, rel=0.1)
    with pytest.raises(AvahazardError, match="release_sigma_m of event unsure"):
        predict(snow_database, "base", write("bad.csv", text.replace(",80", ",-80")))
    with pytest.raises(RejectedRows) as refused:
        predict(snow_database, "base", write("word.csv", text.replace(",80", ",far")))
    assert [(p.line, p.column) for p in refused.value.problems] == [(3, "release_sigma_m")]


def test_the_records_themselves_are_covered(snow_world: Path) -> None:
    file = snow_world / "world" / "events.csv"
    found = predict(str(snow_world / "base.db"), "base", file)
    assert len(found.events) == found.scores.runout.n == 120
    assert abs(found.scores.runout.coverage_90 - 0.9) < 0.08


def test_events_without_a_profile_have_lengths(snow_database: str, write: Write) -> None:
    text = "event_id,fall_height_m,runout_length_m,volume_m3\nr,1000,2000,50000\n"
    found = predict(snow_database, "base", write("straight.csv", text))
    (row,) = found.events
    assert row.coordinate == "length"
    assert row.p_left_profile == 0.0
    assert any("lengths" in note for note in found.notes)
    # L = H / μ, with μ as at any path.
    half = predict(snow_database, "base", write("half.csv", text.replace("1000,", "500,"))).events[
        0
    ]
    assert half.q50_m == pytest.approx(0.5 * row.q50_m)


def test_each_event_has_the_notes_on_its_volume_and_on_the_model(
    snow_database: str, write: Write
) -> None:
    text = f"{NEW}vast,P01,900000000\n"
    small, large, vast = predict(snow_database, "base", write("new.csv", text)).events
    assert small.notes == large.notes
    assert not any("extrapolation" in note for note in small.notes)
    assert set(vast.notes) > set(small.notes)
    assert any(note.startswith("P01: the volume, 900,000,000 m3, is") for note in vast.notes)
    # Records that have changed since are noted with every event, as on the terminal.
    import_files(snow_database, [write("events.csv", "event_id,path_id,left_profile\nz,P01,1\n")])
    stale = predict(snow_database, "base", write("new.csv", text))
    (note,) = (note for note in stale.notes if "records have changed" in note)
    assert all(note in row.notes for row in stale.events)
    assert stale.to_dict()["events"][2]["notes"] == list(stale.events[2].notes)


@pytest.mark.usefixtures("drawn_little")
def test_values_that_the_model_does_not_know_are_noted(snow_database: str, write: Write) -> None:
    add(snow_database, "base", ["snow-type"], "snow")
    rows = "a,P01,3000,Wet\nb,P01,3000,slush\nc,P01,3000,\nd,P01,3000,dry\n"
    header = "event_id,path_id,volume_m3,snow_type\n"
    found = predict(snow_database, "snow", write("snow.csv", f"{header}{rows}"))
    wet, slush, blank, dry = (row.q50_m for row in found.events)
    assert wet != dry
    assert slush == pytest.approx(dry, abs=10.0)
    assert blank == pytest.approx(dry, abs=10.0)
    assert [note for note in found.notes if note.startswith("snow_type: ")] == [
        "snow_type: the model does not know slush, which counts as dry.",
        "snow_type: not given for 1 of 4 events: there it counts as dry.",
    ]
    alone = run_block(snow_database, "P01", RunoutRequest(model="snow", volume_m3=3e3))
    assert any(note.startswith("μ is that of snow_type = dry:") for note in alone.notes or ())
    known = predict(snow_database, "snow", write("known.csv", header + rows[:15]))
    assert not any(note.startswith("snow_type") for note in known.notes)


@pytest.mark.usefixtures("drawn_little")
def test_events_are_counted_among_the_records(
    snow_database: str, snow_world: Path, write: Write
) -> None:
    add(snow_database, "base", ["covariate:avalanches_nearby"], "near")
    rows = csv.DictReader((snow_world / "world" / "events.csv").open(encoding="utf-8"))
    busy = min(date.fromisoformat(row["date"]) for row in rows if row["path_id"] == "P01")

    def median(day: date, sigma_m: float = 0.0) -> float:
        header = "event_id,path_id,date,volume_m3,release_sigma_m\n"
        row = f"a,P01,{day},3000,{sigma_m}\n"
        (found,) = predict(snow_database, "near", write("new.csv", header + row)).events
        return found.q50_m

    quiet = date(1800, 1, 1)
    assert abs(median(busy) - median(quiet)) > 1.0
    for day in (busy, quiet):
        assert median(day, 0.1) == pytest.approx(median(day), abs=5.0)


def test_normal_friction_tells_of_draws_below_zero(snow_database: str, write: Write) -> None:
    calibrate(snow_database, "normal", CalibrateRequest(distribution="normal", chains=2, draws=100))
    found = predict(snow_database, "normal", write("new.csv", NEW))
    for row in found.events:
        assert np.isfinite(row.mean_m)


def test_what_cannot_be_predicted(snow_database: str, write: Write) -> None:
    with pytest.raises(RejectedRows) as told:
        predict(snow_database, "base", write("bad.csv", "event_id,path_id,volume_m3\na,P01,-4\n"))
    assert "nothing was predicted" in told.value.message
    with pytest.raises(RejectedRows):
        predict(snow_database, "base", write("lost.csv", "event_id,path_id\na,nowhere\n"))
    with pytest.raises(AvahazardError, match="There is no model"):
        predict(snow_database, "other", write("new.csv", NEW))
