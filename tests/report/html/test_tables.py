"""Tables of the report, cell by cell."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from avahazard.report.html import model_tables, path_tables
from avahazard.report.html.content import ReportContent
from avahazard.report.html.model_tables import HtmlTable, made_table
from avahazard.report.html.path_tables import bounds_table
from avahazard.report.html.words import NARROW as S
from avahazard.results.base import Rows
from avahazard.results.calibration import ParameterSummary
from avahazard.results.comparison import Failure
from tests.report.html.world import NAMES
from tests.results.samples import CALIBRATION, DIAGNOSIS, NOT_COMPARED

ROW: dict[str, Any] = {
    "path_id": "scey",
    "return_period_years": 100.0,
    "volume_m3": 20000.0,
    "runout_x_m": {"mean": None, "q05": 900.0, "q50": 1200.0, "q95": None},
    "runout_elevation_m": {"mean": None, "q05": None, "q50": 1100.0, "q95": 1300.0},
    "p_left_profile": 0.1,
    "p_not_released": 0.0,
    "extrapolated": True,
    "design": {
        "runout_x_m": {"q05": 1500.0, "q50": 1700.0, "q95": None},
        "runout_elevation_m": {"q05": None, "q50": 1000.0, "q95": 1050.0},
        "p_beyond": 0.08,
        "point": None,
        "farthest_record": {"runout_x_m": 1650.0, "date": "1950-02-13"},
        "records_beyond": 0,
        "n_records": 9,
        "interval": "what varies",
    },
}


def cells(table: HtmlTable, row: int = 0) -> dict[str, str]:
    assert all(len(row) == len(table.columns) for row in table.rows)
    return dict(zip((c.removeprefix(">") for c in table.columns), table.rows[row], strict=True))


def test_the_line_is_the_design_runout_with_the_records(content: ReportContent) -> None:
    found = cells(path_tables.lines_table(replace(content, rows=[ROW])))
    assert found == {
        "path": NAMES["scey"],
        "for": "100 years",
        "runout x (5 to 95 %)": f"1{S}700 m (1{S}500 to beyond)",
        "elevation there": f"1{S}000 m (1{S}050 to beyond)",
        "records past it": "0 of 9",
        "farthest record": f"1{S}650 m (1950-02-13)",
        "mind": "extrapolated; 8.0 % beyond the profile",
    }
    volume = {**ROW, "return_period_years": None, "design": None}
    assert path_tables.lines_table(replace(content, rows=[volume])).rows == []


def test_avalanches_of_the_volume_have_a_table_of_their_own(content: ReportContent) -> None:
    found = cells(path_tables.of_volume_table(replace(content, rows=[ROW])))
    assert found == {
        "path": NAMES["scey"],
        "for": "100 years",
        "volume": f"20{S}000 m³",
        "runout x (5 to 95 %)": f"1{S}200 m (900 to beyond)",
        "elevation there": f"1{S}100 m (1{S}300 to beyond)",
        "leave": "10 %",
    }


def test_a_block_that_does_not_start_has_no_line(content: ReportContent) -> None:
    held = replace(content, rows=[{**ROW, "p_not_released": 0.9, "design": None}])
    for table in (path_tables.lines_table(held), path_tables.of_volume_table(held)):
        assert cells(table)["runout x (5 to 95 %)"] == "not released"


def test_bounds_hold_every_number(content: ReportContent) -> None:
    table = bounds_table(content)
    assert len(table.rows) == len(content.rows)
    found = cells(table)
    row = content.rows[0]
    assert found["x of V by nature alone"] != "–"
    assert found["years"] == f"{row['first_year']}–{row['last_year']}"
    bare = cells(bounds_table(replace(content, rows=[ROW])))
    assert bare["design x, m"] == f"1{S}700"
    assert bare["design elevation, m"] == f"1{S}000"
    assert bare["x of V, m"] == f"1{S}200"
    assert bare["volume V, m³"] == f"20{S}000"
    assert table.columns.index(">design x, m") < table.columns.index(">x of V, m")


def test_paths_are_told_with_their_records(content: ReportContent) -> None:
    table = path_tables.paths_table(content.paths)
    assert [cells(table, k)["events"] for k in range(3)] == ["19", "15", "27"]
    assert cells(table, 2)["left"] == "1"
    assert [row[0] for row in table.rows] == [view.name for view in content.paths]


def test_zones_and_alpha_beta_are_listed(content: ReportContent) -> None:
    zones = path_tables.zones_table(content.paths)
    assert zones is not None
    assert {row[0] for row in zones.rows} == {NAMES["scey"]}
    baseline = path_tables.alpha_beta_table(content.paths)
    assert baseline is not None
    assert len(baseline.rows) == 6
    bare = [replace(view, zones=None, alpha_beta=()) for view in content.paths]
    assert path_tables.zones_table(bare) is None
    assert path_tables.alpha_beta_table(bare) is None


def test_parameters_have_as_many_digits_as_they_are_sure() -> None:
    parameters = {
        "a": ParameterSummary(0.51993, 0.0073, 0.52, 0.5, 0.53, ""),
        "n": ParameterSummary(3.2e-7, 9e-8, 3e-7, 1e-7, 5e-7, "1/m3"),
        "path:x": ParameterSummary(0.0, 1.0, 0.0, 0.0, 1.0, ""),
    }
    table = model_tables.parameters_table(replace(CALIBRATION, parameters=parameters))
    assert len(table.rows) == 2
    assert cells(table)["mean"] == "0.5199"
    assert cells(table, 1)["mean"] == "3.20 × 10⁻⁷"
    assert cells(table, 1)["unit"] == "1/m³"


def test_scores_and_failures_come_from_the_comparison(content: ReportContent) -> None:
    assert content.comparison is not None
    scores = model_tables.scores_table(content.comparison)
    assert [(row[0], row[1]) for row in scores.rows] == [
        (name, what)
        for name in ("paths kept back", "records of the calibration")
        for what in ("elevation", "distance along the path")
    ]
    fails = Failure("snow_type", "scey", 9, -50.0, 1e-4)
    comparison = replace(content.comparison, where_it_fails=Rows([fails] * 40))
    table = model_tables.failures_table(comparison, NAMES)
    assert (len(table.rows), table.shown) == (40, 40)
    assert list(cells(table).values()) == [
        "snow type", NAMES["scey"], "9", "−50 m", "< 0.001", "beyond chance",
    ]  # fmt: skip
    rows = Rows([replace(fails, p_value=1.0)] * 40 + [fails])
    chance = replace(content.comparison, where_it_fails=rows)
    table = model_tables.failures_table(chance, {})
    assert (len(table.rows), table.shown) == (41, 1)
    assert cells(table)["p"] == "< 0.001"
    (seen, first), (folded, rest) = table.parts
    assert (seen, folded) == (False, True)
    assert (len(first), len(rest)) == (1, 40)
    assert table.folded == "40 that may be chance"


def test_the_ladder_has_dashes_for_what_was_not_compared(content: ReportContent) -> None:
    (row,) = content.ladder
    bare = replace(NOT_COMPARED, parent="m", added=("season",))
    table = model_tables.ladder_table(replace(content, ladder=[row, bare]))
    assert cells(table, 1)["error"] == "–"
    assert cells(table, 1)["added"] == "season"


def test_candidates_and_what_to_measure(content: ReportContent) -> None:
    assert content.diagnosis is not None
    table = model_tables.candidates_table(content.diagnosis)
    likelier = [cells(table, k)["records likelier"] for k in (0, 2)]
    assert likelier == [f"8{S}100 times", "no"]
    assert [cells(table, k)["p"] for k in (0, 1)] == ["< 1/40", "< 1/40"]
    assert table.shown == 2
    measure = model_tables.measure_table(content.diagnosis)
    assert measure is not None
    assert cells(measure)["makes the right explanation likelier"] == "400 times"
    assert model_tables.measure_table(DIAGNOSIS) is None


def test_how_it_was_made_names_seed_versions_and_fingerprint(content: ReportContent) -> None:
    made = dict(made_table(content).rows)
    assert made["fingerprint of the records (SHA-256)"] == content.model.data_fingerprint
    assert made["version of avahazard"] == content.versions["avahazard"]
    assert made["seed"] == "0"
    text = str(made_table(replace(content, effect_sha256="ab" * 32)).rows)
    assert "ab" * 32 in text
