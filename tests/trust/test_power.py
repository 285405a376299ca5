"""Power cuts: a short study, and the disk that it is made on."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from benchmarks.trust.disk_replay import Disk, Step, confirmed, disk_of, steps_of
from benchmarks.trust.power import can_cut, cut_power

needs_gcc = pytest.mark.skipif(not can_cut(), reason="there is no gcc to build the log of writes")


@needs_gcc
def test_what_was_confirmed_outlives_a_power_cut(tmp_path: Path) -> None:
    found = cut_power(tmp_path, 20, np.random.default_rng(2), holder="held", model=False)
    assert found.n_confirmed > 0
    assert (found.lost, found.partial, found.damaged) == (0, 0, 0)


@needs_gcc
@pytest.mark.slow
def test_the_study_sees_a_log_that_is_not_synced(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    assert cut_power(tmp_path, 60, rng, holder="held", synchronous="NORMAL").lost > 0


def test_a_disk_keeps_what_was_synced(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"0000")
    disk = disk_of(tmp_path)
    name = str(tmp_path / "a").encode()
    for step in (
        Step("O", 5, os.O_RDWR, name),
        Step("W", 5, 1, b"11"),
        Step("S", 5, 0, b""),
        Step("W", 5, 3, b"2222"),
    ):
        disk.take(step)
    rng = np.random.default_rng(0)
    file = str(tmp_path / "a")
    assert disk.after_cut("none", rng)[file] == b"0110"
    assert disk.after_cut("all", rng)[file] == b"0112222"
    some = {disk.after_cut("some", rng)[file] for _ in range(60)}
    assert some == {b"0110", b"0112222"}


def test_a_sync_keeps_what_stood_when_it_began(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"0000")
    disk = disk_of(tmp_path)
    name = str(tmp_path / "a")
    for step in (
        Step("O", 5, os.O_RDWR, name.encode()),
        Step("O", 6, os.O_RDWR, name.encode()),  # another process
        Step("W", 5, 0, b"1"),
        Step("F", 5, 0, b""),
        Step("W", 6, 1, b"2"),
        Step("R", 0, 0, f"{name}\0{name}-new".encode()),
        Step("S", 5, 0, b""),
    ):
        disk.take(step)
    assert disk.content[0] == b"1000"
    assert set(disk.names) == {name}
    assert set(disk.names_now()) == {f"{name}-new"}


def test_files_are_cut_and_named_by_their_paths(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"0000")
    disk = disk_of(tmp_path)
    name = str(tmp_path / "a")
    for step in (
        Step("P", 0, 2, name.encode()),
        Step("L", 0, 0, f"{name}\0{name}-too".encode()),
        Step("R", 0, 0, f"{name}-unseen\0{name}-other".encode()),
        Step("O", 7, 0, name.encode()),
        Step("S", 7, 0, b""),
    ):
        disk.take(step)
    rng = np.random.default_rng(0)
    assert disk.after_cut("none", rng) == {name: b"00", f"{name}-too": b"00"}


def test_names_come_in_their_order() -> None:
    disk = Disk()
    disk.take(Step("O", 5, os.O_CREAT, b"/no/part"))
    disk.take(Step("W", 5, 0, b"1"))
    disk.take(Step("R", 0, 0, b"/no/part\0/no/whole"))
    rng = np.random.default_rng(0)
    left = {tuple(sorted(disk.after_cut("none", rng))) for _ in range(60)}
    assert left == {(), ("/no/part",), ("/no/part", "/no/whole"), ("/no/whole",)}
    disk.take(Step("S", 5, 0, b""))
    assert disk.after_cut("none", rng) == {"/no/whole": b"1"}


def test_a_log_is_read_as_it_was_written(tmp_path: Path) -> None:
    def number(k: int) -> bytes:
        return k.to_bytes(8, "little", signed=True)

    log = tmp_path / "log"
    log.write_bytes(
        b"W"
        + number(3)
        + number(7)
        + number(2)
        + b"ab"
        + b"C"
        + number(0) * 2
        + number(3)
        + b"ok\n"
    )
    steps = steps_of(log)
    assert steps[0] == Step("W", 3, 7, b"ab")
    assert list(confirmed(steps)) == [(1, "ok")]
