"""The α-β runouts of many lines, by us and by AvaFrame's com2AB."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from avahazard.hazard.alpha_beta import BY_NAME, AlphaBeta, alpha_beta_on_points
from avahazard.hazard.alpha_beta import alpha_beta as on_ground
from avahazard.physics.smooth_profile import smooth_profile
from benchmarks.alpha_beta import PYTHON, com2ab
from benchmarks.measuring import Row, alternate, seconds
from benchmarks.true_worlds import drawn_ground

N_LINES, N_SMOOTHED = 1000, 100
CELL_M = 5.0
SAME_M = 0.1
"""Places so near are one."""


def alpha_beta() -> Row:
    """Seconds a line, from its points to the runout."""
    if PYTHON not in os.environ:
        raise SystemExit(
            f"alpha_beta: {PYTHON} names no Python that has AvaFrame. It wants a NumPy before 2:\n"
            "python3 -m venv avaframe-venv && avaframe-venv/bin/pip install avaframe==2.1"
        )
    lines = [_line(np.random.default_rng([k, 83])) for k in range(N_LINES)]
    asked = [{"x_m": list(x), "y_m": list(y)} for x, y in lines]
    kept: dict[str, list[Any]] = {}
    by = BY_NAME["avaframe"]

    def ours() -> float:
        def every() -> None:
            kept["ours"] = [alpha_beta_on_points(x, y, 0.0, by) for x, y in lines]

        return 1e3 * seconds(every) / N_LINES

    def theirs() -> float:
        told = com2ab(asked)
        kept["theirs"] = told["found"]
        return 1e3 * float(told["seconds"]) / N_LINES

    def smoothed() -> None:
        for x, y in lines[:N_SMOOTHED]:
            on_ground(smooth_profile(x, y), 0.0, by)

    found = alternate(ours, theirs, 3)
    smoothed()  # compiles
    return (
        *found,
        f"{N_LINES} made lines of 2 to 6 km, points every {CELL_M:g} m, taken as they are by both. "
        f"{_agreement(**kept)} Our own sets take them as points with errors, whose ground is "
        "smoothed first, which com2AB does not: "
        f"{1e3 * seconds(smoothed) / N_SMOOTHED:.2f} ms a line.",
    )


def _line(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """x and y (m) every `CELL_M` of a path with steps."""
    x, y = drawn_ground(rng, 1000.0)
    even = np.arange(0.0, x[-1], CELL_M)
    return even, np.interp(even, x, y)


def _agreement(ours: list[AlphaBeta], theirs: list[dict[str, Any]]) -> str:
    """How the β-points, α and runouts of both compare."""
    pairs = list(zip(ours, theirs, strict=True))
    both = [(a, b) for a, b in pairs if a.beta_x is not None and b["beta_s_m"] is not None]
    one = sum((a.beta_x is None) != (b["beta_s_m"] is None) for a, b in pairs)
    same = [(a, b) for a, b in both if abs(a.beta_x - b["beta_s_m"]) <= SAME_M]
    alpha = [abs(a.alpha_deg - b["alpha_deg"]) for a, b in same]
    far = [
        abs(a.runout_x - b["runout_s_m"])
        for a, b in same
        if a.runout_x is not None and b["runout_s_m"] is not None
    ]
    return (
        f"The β-point is one place on {len(same)} of {len(both)} lines on which both have one "
        f"({one} on which one has); there α differs by {np.max(alpha):.1e}° at most, the runout by "
        f"{np.median(far):.1f} m in the median, {np.max(far):.1f} m at most: ours lies within its "
        "step, theirs at the upper end."
    )
