"""The α-β runouts of many lines, by us and by AvaFrame's com2AB."""

from __future__ import annotations

import json
import os
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.hazard.alpha_beta import BY_NAME, AlphaBeta, alpha_beta
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from benchmarks.coverage_study.world import drawn_ground
from benchmarks.measuring import Result, alternate

N_LINES = 1000
CELL_M = 5.0
PYTHON = "AVAFRAME_PYTHON"
RUNNER = Path(__file__).resolve().parents[1] / "avaframe_com2ab.py"
STEP_M = 10.0
"""Length of com2AB's steps: its places are ends of these."""


def measure() -> Result:
    """Seconds a line, from its points to the runout."""
    if PYTHON not in os.environ:
        raise SystemExit(
            f"alpha_beta: {PYTHON} names no Python that has AvaFrame. It wants a NumPy before 2:\n"
            "python3 -m venv avaframe-venv && avaframe-venv/bin/pip install avaframe==2.1"
        )
    lines = [_line(np.random.default_rng([k, 83])) for k in range(N_LINES)]
    asked = json.dumps(
        {"cell_m": CELL_M, "lines": [{"x_m": list(x), "y_m": list(y)} for x, y in lines]}
    )
    kept: dict[str, list[Any]] = {}

    def ours() -> float:
        start = time.perf_counter()
        kept["ours"] = [_runout(x, y) for x, y in lines]
        return (time.perf_counter() - start) / N_LINES

    def theirs() -> float:
        command = [os.environ[PYTHON], str(RUNNER)]
        done = subprocess.run(command, input=asked, stdout=subprocess.PIPE, check=True, text=True)
        told = json.loads(done.stdout)
        kept["theirs"] = told["found"]
        return float(told["seconds"]) / N_LINES

    mine, rival, ratio = alternate(ours, theirs, 3)
    return Result(
        ratio,
        1e3 * mine,
        1e3 * rival,
        "ms a line",
        50.0,
        False,
        "time of AvaFrame's com2AB (its kernel, on a raster of four rows) over ours",
        f"{N_LINES} made lines of 2 to 6 km, points every {CELL_M:g} m. {_agreement(**kept)}",
    )


def _line(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """x and y (m) every `CELL_M` of a path with steps."""
    x, y = drawn_ground(rng, 1000.0)
    even = np.arange(0.0, x[-1], CELL_M)
    return even, np.interp(even, x, y)


def _runout(x: np.ndarray, y: np.ndarray) -> tuple[SmoothProfile, AlphaBeta]:
    smooth = smooth_profile(x, y)
    return smooth, alpha_beta(smooth, 0.0, BY_NAME["avaframe"])


def _agreement(ours: list[tuple[SmoothProfile, AlphaBeta]], theirs: list[dict[str, Any]]) -> str:
    """How the β-points, α and runouts of both compare."""
    pairs = [(a, b) for (_, a), b in zip(ours, theirs, strict=True)]
    both = [(a, b) for a, b in pairs if a.beta_x is not None and b["beta_s_m"] is not None]
    one = sum((a.beta_x is None) != (b["beta_s_m"] is None) for a, b in pairs)
    same = [(a, b) for a, b in both if abs(a.beta_x - b["beta_s_m"]) <= 1.5 * STEP_M]  # type: ignore[operator]
    alpha = [abs(a.alpha_deg - b["alpha_deg"]) for a, b in same]  # type: ignore[operator]
    far = [
        abs(a.runout_x - b["runout_s_m"])
        for a, b in same
        if a.runout_x is not None and b["runout_s_m"] is not None
    ]
    return (
        f"The β-point is the same step or the next on {len(same)} of {len(both)} lines on which "
        f"both have one ({one} on which one has); there α differs by {np.median(alpha):.2f}° in "
        f"the median, {np.max(alpha):.2f}° at most, the runout by {np.median(far):.0f} m in the "
        f"median, {np.quantile(far, 0.99):.0f} m at 99 %."
    )
