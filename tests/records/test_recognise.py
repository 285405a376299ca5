"""Forms known by their headers."""

from __future__ import annotations

import pytest

from avahazard.records.errors import RowProblem
from avahazard.records.recognise import recognise
from avahazard.records.table import table_of


@pytest.mark.parametrize(
    ("header", "name", "kind"),
    [
        ("path_id,name", "x.csv", "paths"),
        ("path_id,x_m,y_m", "x.csv", "profiles"),
        ("path_id,x_m,y_m", "paths.csv", "profiles"),
        ("path_id,x_m", "paths.csv", "paths"),
        ("event_id,path_id,runout_x_m", "profiles.csv", "events"),
        ("event_id,fall_height_m,runout_length_m", "x.csv", "events"),
        ("event_id,h_over_l", "x.csv", "events"),
        ("event_id,x_m,speed_m_s", "events.csv", "velocities"),
        ("event_id,elevation_m,speed_m_s", "x.csv", "velocities"),
    ],
)
def test_kind_by_header(header: str, name: str, kind: str) -> None:
    problems: list[RowProblem] = []
    assert recognise(table_of(name, header.split(","), []), problems) == kind
    assert not problems


@pytest.mark.parametrize(
    ("header", "name", "columns"),
    [
        ("path_id,x_m", "profiles.csv", ["y_m"]),
        ("path_id", "profiles.csv", ["x_m", "y_m"]),
        ("name", "paths.csv", ["path_id"]),
        ("event_id,path_id", "x.csv", ["runout_x_m"]),
        ("event_id,fall_height_m", "x.csv", ["runout_length_m"]),
        ("event_id,x_m", "velocities.csv", ["speed_m_s"]),
        ("event_id,speed_m_s", "x.csv", ["x_m"]),
        ("date", "x.csv", [""]),
    ],
)
def test_missing_columns_are_named(header: str, name: str, columns: list[str]) -> None:
    problems: list[RowProblem] = []
    assert recognise(table_of(name, header.split(","), []), problems) is None
    assert [p.column for p in problems] == columns


def test_events_to_predict_need_no_runout() -> None:
    problems: list[RowProblem] = []
    table = table_of("x.csv", ["event_id", "path_id"], [])
    assert recognise(table, problems, need_runout=False) == "events"
