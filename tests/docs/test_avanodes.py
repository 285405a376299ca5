"""The page on measured speeds has the results."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from benchmarks.avanodes import tables
from benchmarks.study import DOCS, with_parts

PAGE = (DOCS / "avanodes.md").read_text(encoding="utf-8")
NUMBER = re.compile(r"[+-]?\d+(?:\.\d+)?")


def table_rows(page: str) -> list[str]:
    """The rows of the tables of scores, which come before the diagnosis."""
    scores, _, _ = page.partition("## The diag")
    return [line for line in scores.splitlines() if line.startswith("|")]


@pytest.mark.slow
def test_the_tables_are_those_that_come_out(shared_data: Path) -> None:
    written = table_rows(PAGE)
    found = table_rows(with_parts(PAGE, tables(shared_data / "avanodes")))
    assert len(written) == 6 + 5 + 5
    for said, new in zip(written, found, strict=True):
        assert NUMBER.sub("#", said) == NUMBER.sub("#", new)
        numbers = [[float(v) for v in NUMBER.findall(line)] for line in (said, new)]
        # Another machine rounds otherwise, and chains then part.
        assert numbers[1] == pytest.approx(numbers[0], rel=0.1, abs=3.0)


def test_the_page_has_its_tables() -> None:
    assert PAGE.count("| Coulomb |") >= 2
    assert PAGE.count("| with drag |") >= 2
