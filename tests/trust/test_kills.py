"""kill -9: a few of those that `make trust` does, and that its judge sees what is wrong."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from benchmarks.trust.commands import JOBS, write_records
from benchmarks.trust.kills import kill_jobs
from benchmarks.trust.places import Files, faults, places, same_rows
from tests.conftest import missing

SHORT = ("import", "calibrate", "compare", "hazard", "db upgrade", "export .csv")
"""The jobs of the short run."""


@pytest.fixture
def records(tmp_path: Path) -> Path:
    write_records(tmp_path)
    return tmp_path


def test_killed_imports_are_whole_or_not_there(records: Path) -> None:
    rng = np.random.default_rng()
    for killed in kill_jobs(JOBS[:1], Files(), 1, rng, records):
        assert killed.faults == [], killed


@pytest.mark.slow
def test_killed_commands_lose_nothing(records: Path) -> None:
    jobs = [job for job in JOBS if job.name in SHORT]
    for killed in kill_jobs(jobs, Files(), 2 * len(jobs), np.random.default_rng(), records):
        assert killed.faults == [], killed


@pytest.mark.slow
def test_killed_commands_lose_nothing_on_a_server(records: Path) -> None:
    if len(places()) == 1:
        missing("no PostgreSQL server is named in AVAHAZARD_TEST_POSTGRES")
    for killed in kill_jobs(JOBS[:3], places()[1], 3, np.random.default_rng(), records):
        assert killed.faults == [], killed


def test_an_answer_that_is_stored_once_more_is_the_same() -> None:
    once, twice = {"comparisons": Counter({"c": 1})}, {"comparisons": Counter({"c": 2})}
    assert same_rows(twice, once)
    assert not same_rows({"comparisons": Counter({"c": 1, "d": 1})}, once)
    assert not same_rows({"comparisons": Counter()}, once)


def test_the_judge_sees_what_is_lost_foreign_or_in_part() -> None:
    before = {"events": Counter({"old": 1}), "models": Counter()}
    after = {"events": Counter({"old": 1, "a": 1, "b": 1}), "models": Counter({"m": 1})}
    assert faults(before, before, after) == faults(after, before, after) == []
    assert faults({**before, "events": Counter()}, before, after) == [
        "events: 1 rows are lost",
        "the records are stored in part",
    ]
    part = {**before, "events": Counter({"old": 1, "a": 1})}
    assert faults(part, before, after) == ["the records are stored in part"]
    assert "are none of the command's" in faults({**after, "x": Counter("y")}, before, after)[0]
