"""The tables of docs/trust.md are those of the kept figures."""

from __future__ import annotations

from benchmarks.study import DOCS, lines, with_parts
from benchmarks.trust import answers
from benchmarks.trust.__main__ import FOUND, PARTS, parts


def test_the_tables_are_written_from_these_figures() -> None:
    made = parts(lines(FOUND))
    assert set(made) == set(PARTS)
    written = (DOCS / "trust.md").read_text(encoding="utf-8")
    assert with_parts(written, made) == written


def test_faults_are_shown() -> None:
    rows = [{"set": "one event", "done": 1, "refused": 2}]
    assert "- one event: KeyError" in answers.page(
        {"rows": rows, "faults": ["one event: KeyError"]}
    )
