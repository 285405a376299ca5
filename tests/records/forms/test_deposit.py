"""Columns of every event."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from avahazard.records.forms.deposit import DepositRow

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
