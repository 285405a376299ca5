"""A dataset on disk equals the dataset in memory."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avahazard.records.collection import data_fingerprint
from avahazard.records.errors import AvahazardError
from avahazard.records.reading import read_records
from avahazard.synth.dataset import Settings
from avahazard.synth.effects import CATALOGUE
from avahazard.synth.writing import write_dataset
from tests.synth.datasets import dataset


@pytest.mark.parametrize("key", [None, *CATALOGUE, "covariate:new_snow_cm"])
def test_what_is_written_is_read_back(tmp_path: Path, key: str | None) -> None:
    settings = Settings(speeds=0.1, decoys=4, wrong_share=0.02, censored_share=0.1)
    effects = {} if key is None else {key: 1.0}
    records, truth = dataset(6, n_events=60, effects=effects, settings=settings)
    files = write_dataset(tmp_path / "dataset", records, truth)
    assert [f.name for f in files] == [
        "paths.csv", "profiles.csv", "events.csv", "velocities.csv", "truth.json",
    ]  # fmt: skip
    back = read_records([tmp_path / "dataset"])
    assert back.events == records.events
    assert back.speeds == records.speeds
    assert back.paths == records.paths
    assert data_fingerprint(back) == data_fingerprint(records)
    assert json.loads(files[-1].read_text(encoding="utf-8")) == truth


def test_same_seed_same_bytes(tmp_path: Path) -> None:
    folders = [tmp_path / "one", tmp_path / "two"]
    files = [write_dataset(f, *dataset(3, n_events=50, n_paths=3)) for f in folders]
    assert [f.read_bytes() for f in files[0]] == [f.read_bytes() for f in files[1]]


def test_a_folder_with_something_in_it_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("keep", encoding="utf-8")
    records, truth = dataset(3, n_events=20, n_paths=2)
    with pytest.raises(AvahazardError, match="not an empty folder"):
        write_dataset(tmp_path, records, truth)
    with pytest.raises(AvahazardError, match="not an empty folder"):
        write_dataset(tmp_path / "mine.txt", records, truth)
    assert [f.name for f in tmp_path.iterdir()] == ["mine.txt"]


def test_a_world_that_cannot_be_written_leaves_an_empty_folder(tmp_path: Path) -> None:
    records, truth = dataset(3, n_events=50, n_paths=3)
    with pytest.raises(TypeError):
        write_dataset(tmp_path / "one", records, {**truth, "no": object()})
    assert list((tmp_path / "one").iterdir()) == []
    assert write_dataset(tmp_path / "one", records, truth)
