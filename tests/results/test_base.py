"""Results: their JSON, their frames, their pictures."""

from __future__ import annotations

import json
from dataclasses import field
from pathlib import Path

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.results.base import ABSENT, PICTURES, Result, Rows, plain, steps
from avahazard.results.comparison import Ladder
from tests.results.samples import COMPARISON, LADDER_ENTRY


class Inner(Result):
    """A part."""

    x: float
    name: str


class Outer(Result):
    """A whole."""

    parts: Rows[Inner]
    sums: dict[str, Inner]
    values: tuple[float | None, ...]
    more: float | None = field(default=None, metadata=ABSENT)


WHOLE = Outer(Rows([Inner(1.0, "a"), Inner(np.nan, "b")]), {"s": Inner(3.0, "c")}, (1.0, None))


def test_json_has_the_fields_and_no_nan() -> None:
    assert WHOLE.to_dict() == {
        "parts": [{"x": 1.0, "name": "a"}, {"x": None, "name": "b"}],
        "sums": {"s": {"x": 3.0, "name": "c"}},
        "values": [1.0, None],
    }


def test_what_may_be_absent_is_left_out_only_where_it_is_none() -> None:
    assert "more" not in WHOLE.to_dict()
    assert Outer(Rows(), {}, (), 0.0).to_dict()["more"] == 0.0


def test_a_document_comes_back_as_the_result() -> None:
    whole = Outer(Rows([Inner(1.0, "a")]), {"s": Inner(3.0, "c")}, (1.0, None))
    again = Outer.from_dict(whole.to_dict())
    assert again == whole
    assert isinstance(again.parts, Rows)


def test_rows_are_a_frame() -> None:
    frame = WHOLE.parts.to_frame()
    assert list(frame.columns) == ["x", "name"]
    assert frame["x"].isna().tolist() == [False, True]
    assert "<table" in WHOLE.parts._repr_html_()


def test_a_list_is_a_frame_of_its_rows_and_short_to_look_at() -> None:
    ladder = Ladder(Rows([LADDER_ENTRY, LADDER_ENTRY]))
    assert len(ladder.to_frame()) == 2
    assert repr(ladder) == "Ladder(rows=<2>)"
    assert repr(ladder.rows) == "Rows(2 LadderEntry)"
    assert len(repr(LADDER_ENTRY)) < 400
    assert "{" not in Rows([COMPARISON])._repr_html_()


def test_nested_keys_are_joined_by_dots() -> None:
    assert WHOLE.to_frame()["sums.s.x"].tolist() == [3.0]


def test_a_picture_is_drawn_or_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def draw_part(file: Path, part: Inner) -> None:
        file.write_text(f"<svg>{part.name}</svg>", encoding="utf-8")

    monkeypatch.setitem(PICTURES, Inner, draw_part)
    part = WHOLE.parts[0]
    assert part.plot(tmp_path / "p.svg").read_text(encoding="utf-8") == "<svg>a</svg>"
    assert part.plot()._repr_svg_() == "<svg>a</svg>"
    with pytest.raises(AvahazardError, match="no picture of Outer"):
        WHOLE.plot()


def test_the_whole_goes_up_once() -> None:
    told: list[tuple[str, float]] = []
    first, second, third = steps(lambda what, share: told.append((what, share)), (2, 1, 1))
    inner = steps(second, (1, 3))
    for tell, what, share in (
        (first, "a", 0.0),
        (first, "a", 1.0),
        (inner[0], "b", 1.0),
        (inner[1], "c", 5.0),  # more than all of it is all of it
        (third, "d", 0.0),
        (third, "d", 1.0),
    ):
        tell(what, share)
    assert [share for _, share in told] == pytest.approx([0.0, 0.5, 0.5625, 0.75, 0.75, 1.0])
    assert "".join(what for what, _ in told) == "aabcdd"


def test_arrays_scalars_and_missing_numbers_become_plain() -> None:
    value = {
        "a": np.array([[1.5, np.nan]]),
        "b": (np.int64(3), np.bool_(True), float("inf")),
        7: None,
        "d": "text",
    }
    expected = {"a": [[1.5, None]], "b": [3, True, None], "7": None, "d": "text"}
    assert plain(value) == expected
    assert json.loads(json.dumps(plain(value), allow_nan=False)) == expected
