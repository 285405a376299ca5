"""A forked command reports what it writes, and can be killed there."""

from __future__ import annotations

import signal
from pathlib import Path

from benchmarks.trust.commands import fork, make_state, write_records
from benchmarks.trust.places import Files, contents, copied

IMPORT = ("import", "world")


def test_a_forked_command_is_killed_at_a_statement(tmp_path: Path) -> None:
    write_records(tmp_path)
    database = Files().new(tmp_path)
    make_state("empty", database, tmp_path)
    with copied(Files(), database, tmp_path / "whole") as whole:
        process = fork(whole, IMPORT, tmp_path)
        n = process.count_statements()
        assert n > 2
        assert process.status == 0
        assert contents(whole)["events"].total() > 0
    with copied(Files(), database, tmp_path / "killed") as killed:
        process = fork(killed, IMPORT, tmp_path)
        process.await_statements(n // 2)
        process.end(signal.SIGKILL)
        assert process.status == -signal.SIGKILL
        assert contents(killed) == contents(database)


def test_a_refused_command_ends_by_its_status(tmp_path: Path) -> None:
    process = fork(str(tmp_path / "missing.db"), ("models",), tmp_path)
    process.count_statements()
    assert process.status == 1
