"""The block where it leaves the ground and lands again, against the bare loop."""

from __future__ import annotations

from benchmarks.cases.run_limit import sides
from benchmarks.measuring import Result, alternate


def measure() -> Result:
    """Times per 1000 runs on the spline."""
    ours, theirs, ratio = alternate(*sides("spline"), rounds=21)
    return Result(
        ratio,
        1e3 * ours,
        1e3 * theirs,
        "CPU-ms per 1000 runs",
        0.3,
        False,
        "time of a bare compiled loop of the same multiply-adds over ours",
        "as `run_limit`, on the spline through the same points, where blocks leave the ground and "
        "land again: there ours finds where contact changes as well.",
    )
