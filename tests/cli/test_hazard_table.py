"""Bounds as tables for people."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from rich.console import Console

from avahazard.cli.hazard_tables import show_bounds
from avahazard.results.hazard import (
    FarthestRecord,
    HazardRow,
    PlaceQuantiles,
    RunoutInterval,
    Spread,
    VolumeInterval,
)
from tests.gis.results import DESIGN_RUNOUT
from tests.results.samples import HAZARD_ROW, NO_SPREAD, SPREAD


def row(**more: Any) -> HazardRow:
    return replace(HAZARD_ROW, **more)


def shown(capsys: pytest.CaptureFixture[str], *rows: HazardRow) -> str:
    show_bounds(Console(width=80), rows)
    printed = capsys.readouterr().out
    assert max(map(len, printed.splitlines())) <= 80
    return " ".join(printed.split())


def test_a_volume(capsys: pytest.CaptureFixture[str]) -> None:
    printed = shown(capsys, row())
    assert "p – 123000 1800 1200–2600 1800 1200–2600 0" in printed
    assert "Interval: what varies." in printed
    assert "Design runout" not in printed
    assert "beyond" not in printed
    assert "Volumes of the return periods" not in printed


def test_beyond_the_profile(capsys: pytest.CaptureFixture[str]) -> None:
    spread = Spread(None, 1200.0, 1800.0, None)
    printed = shown(capsys, row(runout_x_m=spread, p_left_profile=0.12))
    assert "1800 1200–beyond" in printed
    assert "12.0%" in printed
    assert "A longer profile would tell" in printed


def test_held_at_the_release(capsys: pytest.CaptureFixture[str]) -> None:
    held = row(
        runout_x_m=NO_SPREAD, runout_elevation_m=NO_SPREAD, p_not_released=0.9, volume_m3=None
    )
    printed = shown(capsys, held)
    assert "any held – held –" in printed
    assert "beyond" not in printed


def test_the_design_runout_leads(capsys: pytest.CaptureFixture[str]) -> None:
    apart = {
        "natural": RunoutInterval(SPREAD, SPREAD, "nature"),
        "parameters": RunoutInterval(SPREAD, SPREAD, "ignorance"),
    }
    far = replace(
        DESIGN_RUNOUT,
        runout_x_m=PlaceQuantiles(2300.0, None, None),
        runout_elevation_m=PlaceQuantiles(None, None, 1040.0),
        p_beyond=0.6,
        point=None,
        farthest_record=FarthestRecord(None, None),
        records_beyond=None,
    )
    printed = shown(
        capsys,
        row(return_period_years=100.0, design=DESIGN_RUNOUT, **apart),
        row(return_period_years=300.0, design=far, extrapolated=True, **apart),
        row(),
    )
    assert "p 100 850 800–930 1537 1515–1552 1.0%" in printed
    assert "p 300* beyond 2300–beyond beyond beyond–1040 60.0%" in printed
    assert "p 100 1 of 7 900 1950-02-13" in printed
    assert "p 300* – of 7 beyond undated – –" in printed
    assert printed.index("Design runout") < printed.index("Runout of avalanches of one volume")
    assert "Another question: where avalanches of the T-year volume" in printed
    assert "p 300* 123000 1200–2600 1200–2600" in printed
    assert "natural: nature. parameters: ignorance." in printed
    assert "Interval: uncertainty." in printed
    assert f"in {DESIGN_RUNOUT.point.crs}." in printed
    assert "*: an extrapolation" in printed


def test_no_design_runout_where_the_rate_is_not_known(capsys: pytest.CaptureFixture[str]) -> None:
    printed = shown(capsys, row(return_period_years=100.0))
    assert "p 100 unknown – unknown – –" in printed
    assert "Records past" not in printed


def test_return_periods_tell_where_volumes_come_from(capsys: pytest.CaptureFixture[str]) -> None:
    returned = {
        "return_period_years": 100.0,
        "volume_method": "GEV",
        "volume_interval_m3": VolumeInterval(5e4, 2.5e6),
        "volume_source": "records",
        "n_records": 12,
        "first_year": 1900,
        "last_year": 2000,
        "events_per_year": 0.1188,
        "pooled": True,
        "years_from": "the span of its records",
    }
    other = {**returned, "path_id": "q", "years_from": "observed_from to observed_to"}
    printed = shown(capsys, row(**returned), row(**other))
    assert "50000–2.50e6 12 1900–2000 0.12 pooled" in printed
    assert "lean on those of all paths" in printed
    assert "the span of its records (p); observed_from to observed_to (q)" in printed
