from collections.abc import Callable
from pathlib import Path

import pytest

from avahazard.hazard.frequency_files import read_return_volumes
from avahazard.records.errors import AvahazardError, RejectedRows

Write = Callable[[str, str], Path]


def test_rows_by_path_in_the_order_of_periods(write: Write) -> None:
    text = "path_id,return_period_years,volume_m3,note\nb,100,5e4,x\nb,10,1e4,\na,30,2e4,\n"
    found = read_return_volumes(write("table.csv", text))
    assert found == {"b": [(10.0, 1e4), (100.0, 5e4)], "a": [(30.0, 2e4)]}


def test_every_bad_row_is_told(write: Write) -> None:
    text = "path_id,return_period_years,volume_m3\na,1,1e4\na,10,-3\nb,10,2e4\nb,30,1e4\nb,30,3e4\n"
    with pytest.raises(RejectedRows) as caught:
        read_return_volumes(write("table.csv", text))
    found = [(p.line, p.column) for p in caught.value.problems]
    assert found[:2] == [(2, "return_period_years"), (3, "volume_m3")]
    assert {line for line, _ in found[2:]} <= {5, 6}
    assert len(found) > 2


def test_files_that_cannot_be_read(write: Write, tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="cannot be read"):
        read_return_volumes(tmp_path / "nothing.csv")
    with pytest.raises(AvahazardError, match="has no rows") as caught:
        read_return_volumes(write("empty.csv", "path_id,return_period_years,volume_m3\n"))
    assert "volume_m3" in caught.value.hint
    with pytest.raises(RejectedRows):
        read_return_volumes(write("blank.csv", ""))
