"""Stops whose error is as large as their path is high."""

from __future__ import annotations

from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.vague import vague_stops
from tests.workflow.worlds import bowl


def event(name: str, sigma_m: float, **more: object) -> Event:
    return Event(name, "B", runout_x_m=1500.0, runout_sigma_m=sigma_m, **more)  # type: ignore[arg-type]


def test_errors_of_the_size_of_the_path_are_named() -> None:
    stored = bowl()  # drops 798 m
    new = Records((), (), (event("fine", 700.0), event("vague", 800.0), event("out", 1e4)), ())
    (note,) = vague_stops(new, stored)
    assert "vague: 800 m, B drops 798 m" in note
    assert "out: 10000 m" in note
    assert "fine" not in note


def test_no_note_without_reason() -> None:
    left = Event("left", "B", left_profile=True, runout_sigma_m=1e4)
    new = Records((), (), (event("fine", 25.0), left, Event("bare", "C")), ())
    assert vague_stops(new, bowl()) == []
