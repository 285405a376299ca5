"""What a request takes, what it makes of it, and what it refuses."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.request import Request, fields_of, many, option


class Asked(Request):
    """All kinds of fields."""

    years: Sequence[float] = option((), "Years.", unit="years", over=1.0)
    files: Sequence[Path] = option((), "Files.")
    names: Sequence[str] = option((), "Names.")
    draws: int | None = option(None, "Draws.", what="number of draws", least=2, most=9)
    kind: Literal["open", "channelled"] = option("open", "A kind.")
    plain: bool = False


def test_one_value_is_a_sequence_of_one_and_each_is_there_once() -> None:
    asked = Asked(years=100, files="a.py", names="P01", draws=3)  # type: ignore[arg-type]
    assert (asked.years, asked.files, asked.names) == ((100.0,), (Path("a.py"),), ("P01",))
    assert isinstance(asked.years[0], float)
    assert Asked(names=["b", "a", "b"]).names == ("b", "a")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"years": 1.0}, "The year is 1. It must be a number of years over 1."),
        ({"years": [2.0, float("nan")]}, "The year is nan."),
        ({"draws": 1}, "The number of draws is 1. It must be a number from 2 to 9."),
        ({"draws": 10}, "The number of draws is 10."),
        ({"kind": "chanelled"}, "There is no kind 'chanelled'. Did you mean channelled? It is one"),
    ],
)
def test_what_cannot_be_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(AvahazardError) as caught:
        Asked(**given)
    assert str(caught.value).startswith(message)


def test_fields_know_their_flags() -> None:
    flags = {field.name: field.flag for field in fields_of(Asked)}
    assert flags == {
        "years": "--year",
        "files": "--file",
        "names": "--name",
        "draws": "--draws",
        "kind": "--kind",
    }


def test_text_and_paths_are_one() -> None:
    assert (many("P01"), many(Path("a")), many(3.0)) == (("P01",), (Path("a"),), (3.0,))
    assert many([1.0, 2.0]) == (1.0, 2.0)
