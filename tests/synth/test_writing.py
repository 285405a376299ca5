"""A dataset on disk equals the dataset in memory."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avahazard.records.collection import data_fingerprint
from avahazard.records.errors import AvahazardError
from avahazard.records.reading import read_records
from avahazard.synth import writing
from avahazard.synth.effects import CATALOGUE
from avahazard.synth.making import make_world
from avahazard.synth.world import Settings
from avahazard.synth.writing import write_region, write_world
from tests.synth.worlds import world


@pytest.mark.parametrize("key", [None, *CATALOGUE, "covariate:new_snow_cm"])
def test_what_is_written_is_read_back(tmp_path: Path, key: str | None) -> None:
    settings = Settings(speeds=0.1, decoys=4, wrong_share=0.02, censored_share=0.1)
    effects = {} if key is None else {key: 1.0}
    records, truth = world(6, n_events=60, effects=effects, settings=settings)
    files = write_world(tmp_path / "world", records, truth)
    assert [f.name for f in files] == [
        "paths.csv", "profiles.csv", "events.csv", "velocities.csv", "truth.json",
    ]  # fmt: skip
    back = read_records([tmp_path / "world"])
    assert back.events == records.events
    assert back.speeds == records.speeds
    assert back.paths == records.paths
    assert data_fingerprint(back) == data_fingerprint(records)
    assert json.loads(files[-1].read_text(encoding="utf-8")) == truth


def test_same_seed_same_bytes(tmp_path: Path) -> None:
    folders = [tmp_path / "one", tmp_path / "two"]
    files = [write_world(f, *world(3, n_events=50, n_paths=3)) for f in folders]
    assert [f.read_bytes() for f in files[0]] == [f.read_bytes() for f in files[1]]


def test_a_folder_with_something_in_it_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("keep", encoding="utf-8")
    records, truth = world(3, n_events=20, n_paths=2)
    with pytest.raises(AvahazardError, match="not an empty folder"):
        write_world(tmp_path, records, truth)
    with pytest.raises(AvahazardError, match="not an empty folder"):
        write_world(tmp_path / "mine.txt", records, truth)
    assert [f.name for f in tmp_path.iterdir()] == ["mine.txt"]


def test_a_world_that_cannot_be_written_leaves_an_empty_folder(tmp_path: Path) -> None:
    records, truth = world(3, n_events=50, n_paths=3)
    with pytest.raises(TypeError):
        write_world(tmp_path / "one", records, {**truth, "no": object()})
    assert list((tmp_path / "one").iterdir()) == []
    assert write_world(tmp_path / "one", records, truth)


def test_parts_are_worlds_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writing, "PART_PATHS", 3)
    made = write_region(tmp_path / "one", 7, 40, 8, {"forest-drag": 1.0}, Settings())
    assert Path(made.files[-1]).name == "truth.json"
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
        assert Path(one).read_bytes() == Path(other).read_bytes()
