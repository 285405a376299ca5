"""Columns of every event."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from avahazard.records.rows import DepositRow, StraightRow

SIDES = ("deposit_length_m", "deposit_width_m", "deposit_thickness_m")


@pytest.mark.parametrize("date", ["1950", "1950-02-13", "0001"])
def test_dates(date: str) -> None:
    assert DepositRow.model_validate({"event_id": "e", "date": date}).date == date


@pytest.mark.parametrize("date", ["0000", "1950-02-30", "13.2.1950", "1950-2-3", "195"])
def test_no_dates(date: str) -> None:
    with pytest.raises(ValidationError) as caught:
        DepositRow.model_validate({"event_id": "e", "date": date})
    assert caught.value.errors()[0]["loc"] == ("date",)


@pytest.mark.parametrize("given", [(0,), (0, 1, 2), ()])
def test_a_deposit_is_whole_or_its_length_alone(given: tuple[int, ...]) -> None:
    DepositRow.model_validate({"event_id": "e"} | {SIDES[k]: "10" for k in given})


@pytest.mark.parametrize(
    ("given", "missing"), [((1,), 0), ((2,), 0), ((0, 1), 2), ((0, 2), 1), ((1, 2), 0)]
)
def test_half_a_deposit_names_what_is_missing(given: tuple[int, ...], missing: int) -> None:
    cells = {"event_id": "e"} | {SIDES[k]: "10" for k in given}
    with pytest.raises(ValidationError) as caught:
        DepositRow.model_validate(cells)
    assert caught.value.errors()[0]["ctx"]["column"] == SIDES[missing]
    DepositRow.model_validate(cells | {"volume_m3": "500"})


@pytest.mark.parametrize(
    ("cells", "height", "reach"),
    [
        ({"fall_height_m": "640", "runout_length_m": "1600"}, 640, 1600),
        ({"h_over_l": "0.4", "runout_length_m": "1600"}, 640, 1600),
        ({"h_over_l": "0.4", "fall_height_m": "640"}, 640, 1600),
        (
            {"release_elevation_m": "-900", "runout_elevation_m": "-1540", "h_over_l": "0.4"},
            640,
            1600,
        ),
        (
            {
                "release_elevation_m": "1640",
                "runout_elevation_m": "1000",
                "runout_length_m": "1600",
            },
            640,
            1600,
        ),
        (
            {"fall_height_m": "640", "runout_length_m": "1600", "release_elevation_m": "2000"},
            640,
            1600,
        ),
        ({"fall_height_m": "640", "runout_length_m": "1600", "h_over_l": "0.41"}, 640, 1600),
    ],
)
def test_height_and_reach(cells: dict[str, str], height: float, reach: float) -> None:
    row = StraightRow.model_validate({"event_id": "e"} | cells)
    assert row.height_and_reach == pytest.approx((height, reach))


@pytest.mark.parametrize(
    ("cells", "column"),
    [
        ({"fall_height_m": "640"}, "runout_length_m"),
        ({"runout_length_m": "640"}, "fall_height_m"),
        ({"h_over_l": "0.4", "runout_elevation_m": "900"}, "release_elevation_m"),
        ({"h_over_l": "0.4", "runout_sigma_m": "20"}, "runout_sigma_m"),
        ({"fall_height_m": "900", "runout_length_m": "0.01"}, "runout_length_m"),
        ({"fall_height_m": "0.01", "runout_length_m": "1e6"}, "runout_length_m"),
        ({"release_elevation_m": "900", "runout_elevation_m": "400"}, "runout_length_m"),
        ({"release_elevation_m": "900", "runout_length_m": "1600"}, "fall_height_m"),
        ({"runout_elevation_m": "900", "runout_length_m": "1600"}, "release_elevation_m"),
        (
            {"release_elevation_m": "900", "runout_elevation_m": "950", "runout_length_m": "9"},
            "runout_elevation_m",
        ),
        ({"fall_height_m": "640", "runout_length_m": "1600", "h_over_l": "0.5"}, "h_over_l"),
        (
            {
                "release_elevation_m": "900",
                "runout_elevation_m": "500",
                "runout_length_m": "900",
                "fall_height_m": "300",
            },
            "fall_height_m",
        ),
    ],
)
def test_too_little_or_contradicting(cells: dict[str, str], column: str) -> None:
    with pytest.raises(ValidationError) as caught:
        StraightRow.model_validate({"event_id": "e"} | cells)
    assert caught.value.errors()[0]["ctx"]["column"] == column


def test_the_ratio_alone_has_neither_height_nor_reach() -> None:
    row = StraightRow.model_validate({"event_id": "e", "h_over_l": "0.4"})
    assert row.height_and_reach == (None, None)


@pytest.mark.parametrize("cells", [{}, {"fall_height_m": "640"}])
def test_what_is_to_be_predicted_needs_no_reach(cells: dict[str, str]) -> None:
    StraightRow.model_validate({"event_id": "e"} | cells, context={"need_runout": False})
