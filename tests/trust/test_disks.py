"""Bad disks and clocks: a few of those that `make trust` does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.trust.commands import JOBS, make_state, write_records
from benchmarks.trust.disks import can_mount, disturb, leave_alone, on_mounted
from benchmarks.trust.places import Files

mounts = pytest.mark.skipif(not can_mount(), reason="no file system can be mounted here")


@mounts
def test_a_full_disk(tmp_path: Path) -> None:
    write_records(tmp_path)
    place, job = Files(), JOBS[0]
    start = place.new(tmp_path)
    make_state(job.state, start, tmp_path)
    alone = leave_alone(job, start, tmp_path)
    found = on_mounted(job, alone, tmp_path, free_kb=8)
    assert found.faults == []
    assert found.told


@mounts
@pytest.mark.slow
def test_bad_disks_and_clocks(tmp_path: Path) -> None:
    write_records(tmp_path)
    jobs = [job for job in JOBS if job.name in ("import", "hazard", "export .csv", "db upgrade")]
    for found in disturb(jobs, 2, np.random.default_rng(), tmp_path):
        assert found.faults == [], found
