"""AvaFrame's environment, its folders, and what comes back from them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.engines.com1dfa import PLACE, find_python, settings_of
from avahazard.gis.avaframe_project import HALF_WIDTH_M, ground, made_release, stop_of, thickness_of
from avahazard.gis.hazard_map import PathLine
from avahazard.gis.systems import read_system
from avahazard.records.collection import TerrainCrop
from avahazard.records.errors import AvahazardError
from tests.engines.slope import write_program


def _ground():
    crs = read_system("EPSG:31287")
    x = np.arange(0.0, 1001.0, 50.0)
    line = PathLine(
        x, 1000.0 - x, np.column_stack([380_000.0 + x, np.full(21, 400_000.0)]), "", crs
    )
    east = 379_900.0 + 10.0 * (np.arange(120) + 0.5)
    height = np.tile(1000.0 - (east - 380_000.0), (60, 1)).astype(np.float32)
    return ground(line, TerrainCrop("P", "EPSG:31287", 379_900.0, 400_300.0, 10.0, height))


def test_a_missing_or_old_avaframe_is_told_with_its_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(PLACE, str(tmp_path / "nowhere"))
    with pytest.raises(AvahazardError, match="There is no AvaFrame here") as told:
        find_python()
    assert "make avaframe" in str(told.value.hint)
    monkeypatch.setenv(PLACE, str(write_program(tmp_path, "1.12")))
    with pytest.raises(AvahazardError, match=r"has avaframe 1\.12"):
        find_python()
    monkeypatch.setenv(PLACE, str(write_program(tmp_path, "2.1.3")))
    assert find_python() == tmp_path / "python"


def test_drag_becomes_voellmys_turbulent_friction() -> None:
    assert settings_of(10.0, 0.3, 1.0)["mucoulomb"] == "0.3"
    voellmy = settings_of(10.0, 0.3, 0.5, drag_per_m=0.01)
    # g u² / (ξ h) = drag u²
    assert 9.81 / (float(voellmy["xsivoellmy"]) * 0.5) == pytest.approx(0.01, rel=1e-3)


def test_a_made_release_holds_the_volume_about_the_place() -> None:
    there = _ground()
    corners = made_release(there, 300.0, 80.0, 5000.0)
    assert corners.mean(axis=0) == pytest.approx([380_300.0, 400_000.0])
    sides = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    assert sorted(sides) == pytest.approx([44.2, 44.2, 80.0, 80.0], abs=0.1)  # 45°: V cos θ / 80 m
    thickness = thickness_of(there, corners, 5000.0)
    assert thickness * sides[0] * sides[1] / np.cos(np.pi / 4) == pytest.approx(5000.0, rel=0.01)
    assert thickness == pytest.approx(1.0, rel=0.01)


def test_the_stop_is_the_farthest_cell_over_the_limit_near_the_line() -> None:
    there = _ground()
    peak = np.zeros(there.crop.elevation_m.shape, np.float32)
    assert np.isnan(stop_of(there, peak))
    peak[30, 40] = 2.0
    assert stop_of(there, peak) == pytest.approx(305.0)
    peak[30, 70] = 0.9  # under 1 kPa
    peak[1, 90] = 50.0  # too far from the line
    assert abs(there.crop.north_m - 15.0 - 400_000.0) > HALF_WIDTH_M
    assert stop_of(there, peak) == pytest.approx(305.0)
