"""A region in parts: all are there, by names of their own, and import takes them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avahazard.records.reading import read_records
from avahazard.synth import region
from avahazard.synth.making import make_world
from avahazard.synth.region import write_region
from avahazard.synth.settings import Settings


def test_parts_are_worlds_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(region, "PART_PATHS", 3)
    made = write_region(tmp_path / "one", 7, 40, 8, {"forest-drag": 1.0}, Settings())
    assert [file.name for file in made.files][-1] == "truth.json"
    assert (made.n_paths, made.n_events) == (8, 40)
    found = read_records([tmp_path / "one"])
    names = [path.path_id for path in found.paths]
    assert names == [f"R001-P0{k}" for k in (1, 2, 3)] + [f"R002-P0{k}" for k in (1, 2, 3)] + [
        "R003-P01",
        "R003-P02",
    ]
    assert len({event.event_id for event in found.events}) == 40
    assert len({profile.y_m.tobytes() for profile in found.profiles}) == 8
    truth = json.loads((tmp_path / "one" / "truth.json").read_text())
    assert [part["n_paths"] for part in truth["parts"]] == [3, 3, 2]
    seed = truth["parts"][1]["seed"]
    alone, _ = make_world(seed, truth["parts"][1]["n_events"], 3, {"forest-drag": 1.0})
    mine = [event for event in found.events if event.event_id.startswith("R002-")]
    assert [e.volume_m3 for e in mine] == [e.volume_m3 for e in alone.events]
    again = write_region(tmp_path / "two", 7, 40, 8, {"forest-drag": 1.0}, Settings())
    for one, other in zip(made.files, again.files, strict=True):
        assert one.read_bytes() == other.read_bytes()
