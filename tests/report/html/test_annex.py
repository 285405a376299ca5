"""What the annex says in sentences."""

from __future__ import annotations

from dataclasses import replace

from avahazard.notes import Note
from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import every_note, notes_of
from tests.report.html.pages import section_words
from tests.report.html.world import NAMES


def test_notes_are_a_line_each_kind_and_every_one_is_there(content: ReportContent) -> None:
    row = content.rows[0]
    name = NAMES[row.path_id]
    stale, unconverged = Note("stale", model="m"), Note("unconverged", model="m")
    twice = Note("recorded_twice", "e1 = e2")
    own = (Note("extrapolated", period=500.0), Note.ready("as it was said before."))
    noted = replace(row, notes=(*own, stale, unconverged, twice))
    changed = replace(content, rows=[noted], of_model=(twice,))
    text = " ".join(notes_of(changed))
    assert f"{name}: 500 years are over twice the observed years" in text
    assert f"{name}: as it was said before." in text
    assert "since m was calibrated" not in text  # the brief says it, of the model as it is now
    assert "chains of m" not in text
    assert text.count("e1 = e2: alike in path, day and stop") == 1
    both = [
        replace(row, path_id="scey", notes=own[:1]),
        replace(row, path_id="nants", notes=own[:1]),
    ]
    several = replace(content, rows=both, of_model=())
    assert len(notes_of(several)) == 1
    assert len(every_note(several)) == 2


def test_what_is_not_known_is_counted(content: ReportContent) -> None:
    event = replace(content.events[0], volume_m3=None, date=None, left_profile=True, path_id=None)
    events = (event, *content.events[1:])
    text = section_words(replace(content, events=events, covariates={"snow": 1}), "data")
    for words in ("no volume", "no date", "ran beyond", "no path", "“snow”", "No speeds"):
        assert words in text


def test_every_picture_of_speed_carries_the_caveat(content: ReportContent) -> None:
    limited = replace(content, speed_limited=True)
    for key in ("paths", "limits"):
        assert "The model has no drag" in section_words(content, key)
        assert "The model has no drag" not in section_words(limited, key)
