"""Making a dataset on disk."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.records.reading import read_records
from avahazard.workflow.requests import SynthRequest
from avahazard.workflow.synth import synthesise


def test_document_says_what_is_in_the_folder(tmp_path: Path) -> None:
    effects = ["cohesion", "season"]
    made = synthesise(
        tmp_path / "w", SynthRequest(effects=effects, strength=0.5, events=60, paths=4, seed=5)
    )
    records = read_records([tmp_path / "w"])
    truth = json.loads((tmp_path / "w" / "truth.json").read_text(encoding="utf-8"))
    assert (made.n_events, made.n_paths) == (len(records.events), len(records.paths)) == (60, 4)
    assert made.n_speeds == len(records.speeds) > 0
    assert made.effects == truth["effects"]
    assert {e["strength"] for e in truth["effects"].values()} == {0.5}


def test_nothing_is_written_for_an_unknown_effect(tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="no effect"):
        synthesise(tmp_path / "w", SynthRequest(effects=["gravity"]))
    assert not (tmp_path / "w").exists()
