"""The page on measured speeds says what comes out."""

from __future__ import annotations

import re
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NUMBER = re.compile(r"[+-]?\d+(?:\.\d+)?")


def table_rows(page: str) -> list[str]:
    """The rows of the tables of scores, which come before the diagnosis."""
    scores, _, _ = page.partition("## What the diag")
    return [line for line in scores.splitlines() if line.startswith("|")]


@pytest.mark.slow
def test_the_tables_are_those_that_come_out(shared_data: Path) -> None:
    spec = spec_from_file_location("avanodes", ROOT / "benchmarks" / "avanodes.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    written = table_rows((ROOT / "docs" / "avanodes.md").read_text(encoding="utf-8"))
    found = table_rows(module.run(shared_data / "avanodes"))
    assert len(written) == 6 + 5 + 5
    for said, new in zip(written, found, strict=True):
        assert NUMBER.sub("#", said) == NUMBER.sub("#", new)
        numbers = [[float(v) for v in NUMBER.findall(line)] for line in (said, new)]
        # Another machine rounds otherwise, and chains then part.
        assert numbers[1] == pytest.approx(numbers[0], rel=0.1, abs=3.0)


def test_the_page_has_its_tables() -> None:
    page = (ROOT / "docs" / "avanodes.md").read_text(encoding="utf-8")
    assert page.count("| Coulomb |") >= 2
    assert page.count("| with drag |") >= 2
