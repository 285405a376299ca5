"""Pictures into files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import avahazard.report.picture  # noqa: F401 (how results are drawn)
from avahazard.records.errors import AvahazardError
from avahazard.report.picture import FORMATS, figure
from avahazard.results.base import Rows
from avahazard.results.comparison import Ladder
from tests.results.samples import (
    CALIBRATION,
    CANDIDATE,
    COMPARISON,
    DIAGNOSIS,
    FRICTIONS,
    LADDER_ENTRY,
)


@pytest.mark.parametrize("suffix", FORMATS)
def test_every_format_is_written(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"a{suffix.upper()}"
    with figure(file) as drawn:
        drawn.add_subplot().plot([0.0, 1.0])
    assert file.stat().st_size > 1000


def test_a_name_of_no_picture(tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="not the name of a picture"), figure(tmp_path / "a"):
        pass


def test_a_picture_that_fails_leaves_no_file_and_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from matplotlib.figure import Figure  # noqa: PLC0415

    def full(_self: Figure, file: Path, **_: object) -> None:
        file.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    old = tmp_path / "old.png"
    old.write_bytes(b"old")
    monkeypatch.setattr(Figure, "savefig", full)
    for file in (old, tmp_path / "new.png"):
        with pytest.raises(OSError, match="No space"), figure(file):
            pass
    assert [f.name for f in tmp_path.iterdir()] == ["old.png"]
    assert old.read_bytes() == b"old"


DRAWN = [
    (COMPARISON, "base against the records"),
    (DIAGNOSIS, "base is adequate: these data show no missing effect"),
    (Ladder(Rows([LADDER_ENTRY])), "42 m"),
    (FRICTIONS, "all events (3)"),
]


@pytest.mark.parametrize(("result", "word"), DRAWN, ids=lambda value: type(value).__name__)
def test_a_result_draws_itself(tmp_path: Path, result: Any, word: str) -> None:
    file = result.plot(tmp_path / "a.svg")
    assert f"<!-- {word} -->" in file.read_text(encoding="utf-8")
    assert word in result.plot()._repr_svg_()


@pytest.mark.parametrize("result", [CALIBRATION, CANDIDATE])
def test_others_say_that_they_have_no_picture(result: Any) -> None:
    with pytest.raises(AvahazardError, match="no picture") as error:
        result.plot()
    assert "Comparison, Diagnosis, Frictions, Ladder" in error.value.hint
