"""The same as `run_effects` with friction that depends on speed."""

from __future__ import annotations

from benchmarks.cases.run_effects import RATIO, against_solver
from benchmarks.measuring import Result


def measure() -> Result:
    """With drag, forest and speed-weakening."""
    return against_solver(RATIO, 23_000.0, 10.0)
