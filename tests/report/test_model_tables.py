"""Tables of a model: its parameters, scores, failures, ladder and candidates."""

from __future__ import annotations

from dataclasses import replace

from avahazard.report.language import NARROW as S
from avahazard.report.language import TERMINAL, speaking
from avahazard.report.model_tables import (
    budget_table,
    candidates_table,
    compared_parts,
    failures_table,
    ladder_table,
    measure_table,
    offsets_of,
    parameters_table,
    scores_table,
)
from avahazard.report.tables import Table
from avahazard.results.base import Rows
from avahazard.results.calibration import ParameterSummary
from avahazard.results.comparison import BudgetPart, Failure, SpeedScores
from avahazard.results.diagnosis import Diagnosis
from tests.report.html.world import DIAGNOSIS as DOCUMENT
from tests.results.samples import CALIBRATION, COMPARISON, DIAGNOSIS, NOT_COMPARED, RUNOUT


def cells(table: Table | None, row: int = 0) -> dict[str, str]:
    assert table is not None
    assert all(len(row) == len(table.columns) for row in table.rows)
    return dict(zip((c.removeprefix(">") for c in table.columns), table.rows[row], strict=True))


def test_parameters_have_as_many_digits_as_they_are_sure() -> None:
    parameters = {
        "a": ParameterSummary(0.51993, 0.0073, 0.52, 0.5, 0.53, ""),
        "n": ParameterSummary(3.2e-7, 9e-8, 3e-7, 1e-7, 5e-7, "1/m3"),
        "path:x": ParameterSummary(0.0, 1.0, 0.0, 0.0, 1.0, ""),
        "path:y.offset": ParameterSummary(0.2, 0.1, 0.2, 0.1, 0.3, ""),
    }
    model = replace(CALIBRATION, parameters=parameters, effects=("path:y",))
    assert list(offsets_of(model)) == ["x"]
    table = parameters_table(model, offsets=False)
    assert len(table.rows) == 3
    assert cells(table)["mean"] == "0.5199"
    assert cells(table, 1)["mean"] == "3.20 × 10⁻⁷"
    assert cells(table, 1)["unit"] == "1/m³"
    with speaking(TERMINAL):
        plain = parameters_table(model)
    assert len(plain.rows) == 4
    assert cells(plain, 1)["mean"] == "3.2e-07"


def test_another_law_stands_below_its_parameters() -> None:
    model = replace(CALIBRATION, law="asymptotic", effects=("volume-law",))
    assert "mu_inf + (a - mu_inf) exp(-n V)" in parameters_table(model).legend[0]
    assert not parameters_table(replace(model, effects=())).legend


@speaking(TERMINAL)
def test_scores_are_held_out_first_in_every_coordinate() -> None:
    speed = SpeedScores(12, 8.1, -0.3, 4.0, 0.5, 0.9, 1.5)
    runout = replace(RUNOUT, n=12, rmse_m=81.04, bias_m=-3.0, crps_m=40.0, coverage_90=0.916)
    scores = replace(COMPARISON.scores, runout=runout, runout_x=RUNOUT, speed=speed)
    found = replace(COMPARISON, coordinate="elevation", scores=scores)
    table = scores_table("elevation", compared_parts(found))
    assert [row[:2] for row in table.rows][-3:] == [
        ["in-sample", "elevation, m"],
        ["in-sample", "distance along the path, m"],
        ["in-sample", "speed, m/s"],
    ]
    assert table.rows[0][0] == "held-out"
    own = cells(table, len(table.rows) - 3)
    assert own == {
        "records": "in-sample", "of": "elevation, m", "n": "12", "CRPS": "40.0", "RMSE": "81.0",
        "bias": "-3.0", "in 50 %": "50 %", "in 90 %": "92 %",
    }  # fmt: skip
    of_x = scores_table("x", [("all", scores)])
    assert [row[1] for row in of_x.rows] == ["distance along the path, m", "speed, m/s"]
    ratio = scores_table("h_over_l", [("all", replace(scores, runout_x=None, speed=None))])
    assert ratio.rows[0][1:4] == ["the ratio H/L", "12", "40.0000"]


def test_what_may_be_chance_is_folded() -> None:
    fails = Failure("snow_type", "scey", 9, -50.0, 1e-4)
    comparison = replace(COMPARISON, where_it_fails=Rows([fails] * 40))
    table = failures_table(comparison, names={"scey": "Scey"})
    assert (len(table.rows), table.shown) == (40, 40)
    assert list(cells(table).values()) == ["snow type", "Scey", "9", "−50", "< 0.001"]
    rows = Rows([replace(fails, p_value=1.0)] * 40 + [fails])
    table = failures_table(replace(COMPARISON, where_it_fails=rows))
    assert (len(table.rows), table.shown) == (41, 1)
    assert cells(table)["p"] == "< 0.001"
    assert table.folded == "40 not significant"


def test_the_budget_says_that_scatter_may_be_missing_physics() -> None:
    parts = Rows((BudgetPart("scatter", 30.0), BudgetPart("snow-type", 40.0)))
    found = replace(COMPARISON, coordinate="elevation", budget=parts, profile_m=3.0)
    table = budget_table(found)
    assert [cells(table, k)["share of squares"] for k in (0, 1)] == ["36 %", "64 %"]
    assert [cells(table, k)["source of error"] for k in (0, 1)] == [
        "scatter, natural or missing in the model",
        "explained by snow-type",
    ]
    assert table is not None
    assert "3.0 m (rms)" in table.legend[0]
    assert budget_table(replace(COMPARISON, budget=Rows())) is None


def test_the_ladder_has_dashes_for_what_was_not_compared() -> None:
    compared = replace(
        NOT_COMPARED, model="m", coordinate="elevation", held_out_crps_m=60.04, crps_m=50.0,
        noise_floor_crps_m=7.0, coverage_90=0.9,
    )  # fmt: skip
    bare = replace(NOT_COMPARED, parent="m", added=("season",))
    table = ladder_table([compared, bare])
    assert cells(table)["held-out CRPS, m"] == "60.0"
    assert cells(table, 1)["held-out CRPS, m"] == "–"
    assert cells(table, 1)["added"] == "season"
    assert "7.0 m" in table.legend[-1]


def test_candidates_and_what_to_measure() -> None:
    found = Diagnosis.from_dict(DOCUMENT)
    table = candidates_table(found)
    assert [cells(table, k)["gain, nats"] for k in (0, 2)] == ["9.0", "−0.1"]
    assert [cells(table, k)["p"] for k in (0, 1)] == ["< 1/40", "< 1/40"]
    assert cells(table)["evidence, nats"] == "9.0"
    assert cells(table)["at-mode CRPS, m"] == "60.0 → 55.0"
    assert "→" not in cells(table, 2)["at-mode CRPS, m"]
    assert table.shown == 2
    assert cells(measure_table(found))["expected gain, nats"] == "6.0"
    assert measure_table(DIAGNOSIS) is None
    assert not any("named" in words for words in table.legend)
    nothing = candidates_table(replace(found, verdict="adequate", missing=(), pairs=Rows()))
    assert "though p is low for" in nothing.legend[-1]
    assert S not in "".join(cells(table).values())
