"""The α-β runout of stored paths."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from avahazard.hazard.alpha_beta import REGRESSIONS, alpha_beta
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.errors import AvahazardError
from avahazard.workflow.database import import_files
from avahazard.workflow.path import alpha_beta_paths

Write = Callable[[str, str], Path]
X = np.arange(0.0, 2401.0, 30.0)


def height(x: np.ndarray) -> np.ndarray:
    return 2000.0 - x + 2.5e-4 * x**2


@pytest.fixture
def selected(database: str, write: Write) -> str:
    """A bowl, its upper part as a path that never flattens, and a path without a profile."""
    write("paths.csv", "path_id,release_elevation_m\nbowl,1900\nsteep,\nbare,\n")
    rows = [("bowl", x) for x in X] + [("steep", x) for x in X[:45]]
    points = "\n".join(f"{name},{x},{height(x):.3f}" for name, x in rows)
    write("events.csv", "event_id,path_id,runout_x_m,date\ne,bowl,1800,1950\n")
    import_files(database, [write("profiles.csv", f"path_id,x_m,y_m\n{points}\n").parent])
    return database


def test_a_row_for_each_path_and_regression(selected: str) -> None:
    rows = alpha_beta_paths(selected)
    assert [(row.path_id, row.coefficients) for row in rows] == [
        *(("bowl", "norway"), ("bowl", "austria")),
        *(("steep", "norway"), ("steep", "austria")),
    ]
    smooth = smooth_profile(X, np.round(height(X), 3))
    for row, regression in zip(rows, REGRESSIONS, strict=False):
        # Of 1900 m on the bowl.
        assert smooth.height(row.release_x_m) == pytest.approx(1900.0, abs=0.01)
        expected = alpha_beta("P", smooth, row.release_x_m, regression)
        assert row.runout_x_m == expected.runout_x_m
        assert row.runout_elevation_m == pytest.approx(smooth.height(row.runout_x_m))
        assert row.runout_x_low_m < row.runout_x_m < row.runout_x_high_m
        assert row.alpha_sd_deg == regression.sd_deg
    assert (rows[2].status, rows[2].runout_x_m) == ("no_beta_point", None)
    assert "never flattens to 10°" in rows[2].notes[0]


def test_what_is_not_there(selected: str, empty_database: Path, tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="no path 'everest'"):
        alpha_beta_paths(selected, "everest")
    with pytest.raises(AvahazardError, match="path bare"):
        alpha_beta_paths(selected, "bare")
    none = str(shutil.copy(empty_database, tmp_path / "none.db"))
    with pytest.raises(AvahazardError, match="No path has a profile"):
        alpha_beta_paths(none)
