"""Tables cell by cell: of rows of `hazard`, zones, volumes, the baseline and the paths."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from avahazard.report.language import ENGLISH, TERMINAL, language_of, speaking
from avahazard.report.language import NARROW as S
from avahazard.report.tables import (
    Table,
    alpha_beta_table,
    apart_table,
    design_table,
    paths_table,
    period_volumes_table,
    points_table,
    speeds_table,
    thinned,
    volume_runout_table,
    zones_table,
)
from avahazard.results.base import Rows
from avahazard.results.hazard import (
    FarthestRecord,
    HazardRow,
    PlaceQuantiles,
    RunoutInterval,
    Spread,
    VolumeInterval,
)
from avahazard.results.terrain import PathSummary, TerrainRunout
from tests.gis.results import DESIGN_RUNOUT
from tests.report.zone_entries import entry
from tests.results.samples import HAZARD_ROW, NO_SPREAD, SPREAD


def row(**more: Any) -> HazardRow:
    return replace(HAZARD_ROW, **more)


def cells(table: Table | None, k: int = 0) -> list[str]:
    assert table is not None
    assert all(len(row) == len(table.columns) for row in table.rows)
    return list(table.rows[k])


def heads(table: Table) -> list[str]:
    return [name.removeprefix(">") for name in table.columns]


FAR = replace(
    DESIGN_RUNOUT,
    runout_x_m=PlaceQuantiles(2300.0, None, None),
    runout_elevation_m=PlaceQuantiles(None, None, 1040.0),
    p_beyond=0.6,
    point=None,
    farthest_record=FarthestRecord(None, None),
    records_beyond=None,
)


@speaking(TERMINAL)
def test_the_design_runout_stands_with_the_records() -> None:
    table = design_table(
        [
            row(return_period_years=100.0, design=DESIGN_RUNOUT),
            row(return_period_years=300.0, design=FAR, extrapolated=True),
            row(),
        ],
        {"p": "Path"},
    )
    assert heads(table) == [
        "path", "T, years", "x, m", "5–95 %", "z, m", "5–95 %", "beyond", "records past it",
        "farthest record, m",
    ]  # fmt: skip
    assert cells(table) == [
        "Path", "100", "850", "800–930", "1537", "1515–1552", "1.0 %", "1 of 7", "900 (1950)",
    ]  # fmt: skip
    assert cells(table, 1) == [
        "Path", "300*", "beyond", "2300–…", "beyond", "…–1040", "60 %", "–", "beyond",
    ]  # fmt: skip
    legend = " ".join(table.legend)
    assert "90 % credible interval" in legend
    assert "uncertainty." in legend
    assert "*: an extrapolation" in legend


def test_numbers_have_the_form_of_the_language() -> None:
    rows = [row(return_period_years=100.0, design=DESIGN_RUNOUT)]
    assert cells(design_table(rows))[4] == f"1{S}537"
    with speaking(language_of("de")):
        assert cells(design_table(rows))[4] == f"1{S}537"


def test_no_design_runout_where_the_rate_is_not_known() -> None:
    rows = [row(return_period_years=100.0), row(return_period_years=30.0, p_not_released=0.9)]
    table = design_table(rows)
    assert [cells(table, k)[:3] for k in (0, 1)] == [
        ["p", "100", "rate unknown"],
        ["p", "30", "not released"],
    ]
    assert len(table.columns) == 3  # the others have nothing to show


def test_places_on_the_map() -> None:
    rows = [row(return_period_years=100.0, design=DESIGN_RUNOUT)]
    assert DESIGN_RUNOUT.point is not None
    assert cells(points_table(rows))[-1] == DESIGN_RUNOUT.point.crs
    assert points_table([row()]) is None


@speaking(TERMINAL)
def test_a_volume() -> None:
    table = volume_runout_table([row()])
    assert cells(table) == ["p", "123000", "1800", "1200–2600", "1800", "1200–2600"]
    assert "what varies." in table.legend
    assert "no design runout" not in " ".join(table.legend)
    spread = Spread(None, 1200.0, 1800.0, None)
    beyond = volume_runout_table([row(runout_x_m=spread, p_left_profile=0.12)])
    assert cells(beyond)[3] == "1200–…"
    assert cells(beyond)[-1] == "12 %"


def test_held_at_the_release() -> None:
    held = row(
        runout_x_m=NO_SPREAD, runout_elevation_m=NO_SPREAD, p_not_released=0.9, volume_m3=None
    )
    assert cells(volume_runout_table([held])) == ["p", "any", "not released"]


@speaking(TERMINAL)
def test_nature_and_parameters_apart() -> None:
    apart = {
        "natural": RunoutInterval(SPREAD, SPREAD, "nature"),
        "parameters": RunoutInterval(SPREAD, SPREAD, "ignorance"),
    }
    table = apart_table([row(), row(return_period_years=300.0, **apart)])
    assert cells(table) == ["p", "300", "123000", "1200–2600", "1200–2600"]
    assert table is not None
    assert table.legend == ["nature.", "ignorance."]
    assert apart_table([row()]) is None


@speaking(TERMINAL)
def test_return_periods_say_where_volumes_come_from() -> None:
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
        "years_from": "the first to the last record of any path",
    }
    other = {**returned, "path_id": "q", "years_from": "observed_from to observed_to"}
    table = period_volumes_table([row(**returned), row(**other), row()])
    assert table is not None
    assert cells(table)[3:] == ["50000–2500000", "12", "1900–2000", "0.12", "all paths"]
    assert "Years: the first to the last record of any path (p)." in table.legend
    assert "Years: observed_from to observed_to (q)." in table.legend


@speaking(TERMINAL)
def test_zones_and_speeds() -> None:
    one = entry()
    table = zones_table([one])
    assert cells(table) == ["P01", "red", "none", "–", "700–200"]
    assert cells(table, 1) == ["P01", "blue*", "100", "900", "700–…"]
    assert cells(design_table([one]))[:4] == ["P01", "30", "850", "800–930"]
    speeds = speeds_table([one])
    assert heads(speeds) == ["x, m", "z, m", "p/year", "u 30", "p 30", "u 300*", "p 300*"]
    assert cells(speeds, -1) == ["900", "1600", "0.012", "100", "120", "100", "120"]
    both = speeds_table([one, entry(beyond=True)])
    assert cells(both, 1) == ["P01", "300*", "100", "90–110", "120", "30–270"]
    beyond = entry(beyond=True)
    red, blue = beyond.zones
    moved = replace(beyond, zones=Rows((red, replace(blue, from_x_m=900.0))))
    with speaking(ENGLISH):
        assert cells(zones_table([moved]), 1)[2:] == ["beyond", "700–beyond"]
    assert zones_table([]) is None


@speaking(TERMINAL)
def test_the_baseline() -> None:
    known = TerrainRunout(
        "p",
        "norway",
        "who",
        "stopped",
        0.0,
        25.0,
        900.0,
        22.5,
        2.3,
        1400.0,
        900.0,
        1300.0,
        None,
        (),
    )
    bare = replace(known, beta_deg=None, alpha_deg=None)
    table = alpha_beta_table([known, bare])
    assert cells(table)[2:] == ["25.0", "900", "22.5", "2.3", "1400", "1300–…"]
    assert cells(table, 1)[2:] == ["no β-point", "–", "–", "–", "–", "–"]
    assert alpha_beta_table([]) is None


@speaking(TERMINAL)
def test_paths_with_their_records() -> None:
    known = PathSummary("p", "Path", "open", 9, 2000.0, 900.0, 1800.0, 4, 1, 1900, 2000, 1e4, 2e5)
    bare = PathSummary("q", None, None, 0, None, None, None, 0, 0, None, None, None, None)
    table = paths_table([known, bare])
    assert cells(table)[1:] == [
        "open", "2000", "900", "1800", "4", "1", "1900–2000", "10000–200000",
    ]  # fmt: skip
    assert cells(table, 1)[1:] == ["–", "–", "–", "–", "0", "–", "–", "–"]


def test_rows_are_thinned_with_the_first_and_the_last() -> None:
    assert thinned(list(range(101)), 10) == list(range(0, 101, 10))
