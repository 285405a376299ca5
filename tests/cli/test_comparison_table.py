"""Scores and failures as people read them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avahazard.cli.model_tables import MOST_LINES, error_words, failures, show_scores
from avahazard.results.base import Rows
from avahazard.results.comparison import Comparison, Failure, SpeedScores
from tests.results.samples import COMPARISON, RUNOUT


def failing(coordinate: str, *bias: float, p: float = 0.01) -> Comparison:
    """A comparison with these biases on one axis."""
    rows = Rows(Failure("path", f"P{k}", 9, b, p) for k, b in enumerate(bias))
    return replace(COMPARISON, coordinate=coordinate, where_it_fails=rows)


@pytest.mark.parametrize(
    ("coordinate", "below", "above"),
    [
        ("elevation", "of elevation lower", "of elevation higher"),
        ("mixed", "farther down", "less far down"),
        ("x", "of x shorter", "of x farther"),
        ("length", "of runout length shorter", "of runout length farther"),
    ],
)
def test_a_bias_is_told_the_right_way_round(coordinate: str, below: str, above: str) -> None:
    """A bias is prediction less record, but in mixed coordinates counted as in elevation."""
    down, up = failures(failing(coordinate, 40.0, -25.0))
    assert f"40 m {below} " in down
    assert f"25 m {above} " in up


def test_chance_is_no_failure_and_the_rest_is_counted() -> None:
    assert len(list(failures(failing("x", 40.0, p=0.06)))) == 1
    lines = list(failures(failing("x", *[40.0] * (MOST_LINES + 3))))
    assert len(lines) == MOST_LINES + 1
    assert " 3 " in lines[-1]


def test_speeds_have_a_row_where_there_are_any() -> None:
    runout = replace(RUNOUT, n=12, rmse_m=81.04, bias_m=-3.0, crps_m=40.0, coverage_90=0.916)
    scores = replace(COMPARISON.scores, runout=runout)
    columns, rows = show_scores("elevation", ("all", scores))
    assert [len(row) for row in rows] == [len(columns)]
    assert {"12", "81.0", "-3.0", "40.0", "50%", "92%"} <= {str(cell) for cell in rows[0]}
    speed = SpeedScores(12, 8.1, -0.3, 4.0, 0.5, 0.9, 1.5)
    _, rows = show_scores("length", ("all", replace(scores, speed=speed)))
    assert [row[1] for row in rows] == ["runout length, m", "speed, m/s"]


def test_elevation_and_distance_are_called_what_they_are() -> None:
    scores = replace(COMPARISON.scores, runout_x=replace(RUNOUT, rmse_m=476.0))
    _, rows = show_scores("elevation", ("all", scores))
    assert [(row[1], row[3]) for row in rows] == [
        ("elevation z, m", "70.0"),
        ("distance x, m", "476.0"),
    ]
    _, rows = show_scores("x", ("all", scores))
    assert [row[1] for row in rows] == ["distance x, m"]


def test_the_errors_of_the_records_are_no_floor_for_all_that_is_not_known() -> None:
    words = error_words(COMPARISON)
    assert "7.0 m (RMSE 12 m)" in words
    assert "(runout, volume, release)" in words
