"""Databases of earlier revisions, with data: one of them here, all in `make trust`."""

from __future__ import annotations

from pathlib import Path

from avahazard.store import tables
from benchmarks.trust.commands import write_records
from benchmarks.trust.places import Files
from benchmarks.trust.upgrades import differences, earlier_revisions, upgrade_all


def test_every_row_outlives_an_upgrade(tmp_path: Path) -> None:
    write_records(tmp_path)
    for found in upgrade_all(Files(), tmp_path, ("0005",), at_once=(1,), full=False):
        assert found.faults == [], found
        assert found.n_rows > 500


def test_all_revisions_but_the_last_are_earlier() -> None:
    assert {*earlier_revisions(), tables.head()} == set(tables._revisions())


def test_a_row_that_changes_is_seen() -> None:
    before = {"events": [{"id": 1, "volume_m3": 5.0}]}
    same = {"events": [{"id": 1, "volume_m3": 5.0, "new": None}]}
    assert differences(before, same) == []
    other = {"events": [{"id": 1, "volume_m3": 6.0, "new": None}]}
    assert differences(before, other) == ["events: rows differ"]
    assert differences(before, {}) == ["events: rows differ"]
