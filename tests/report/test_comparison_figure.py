"""The picture of a comparison."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from avahazard.report.comparison_figure import draw_comparison
from avahazard.results.base import Rows
from tests.results.samples import COMPARISON, FAILURE, FORCE


@pytest.mark.parametrize(
    ("rows", "force"), [([FAILURE], None), ([FAILURE], [FORCE]), ([], [FORCE])]
)
def test_panels(tmp_path: Path, rows: list[Any], force: list[Any] | None) -> None:
    file = tmp_path / "a.svg"
    measured = None if force is None else Rows(force)
    draw_comparison(file, replace(COMPARISON, where_it_fails=Rows(rows), measured_force=measured))
    text = file.read_text(encoding="utf-8")
    assert ("volume: above 80 000 m3 (9)" in text) == bool(rows)
    assert ("Coulomb friction" in text) == bool(force)
