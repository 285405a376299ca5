"""The page is that of the kept figures, and these are what it promises."""

from __future__ import annotations

import json
from pathlib import Path

from benchmarks.trust.code_section import READ, name_of
from benchmarks.trust.page import page
from benchmarks.trust.parts import PARTS

ROOT = Path(__file__).resolve().parents[2]


def test_the_page_is_written_from_these_figures() -> None:
    found = json.loads((ROOT / "benchmarks" / "trust.json").read_text(encoding="utf-8"))
    assert (ROOT / "docs" / "trust.md").read_text(encoding="utf-8") == page(found)
    assert set(found) <= set(PARTS)


def test_every_survivor_was_read() -> None:
    found = json.loads((ROOT / "benchmarks" / "trust.json").read_text(encoding="utf-8"))
    read = json.loads(READ.read_text(encoding="utf-8"))
    assert {name_of(one) for one in found["code"]["survivors"]} == set(read)


def test_faults_are_shown() -> None:
    rows = [{"set": "one event", "done": 1, "refused": 2}]
    found = {"amounts": {"seed": 1}, "rows": rows, "faults": ["one event: KeyError"]}
    assert "**1 at fault:**\n\n- `one event: KeyError`" in page({"degenerate": found})
