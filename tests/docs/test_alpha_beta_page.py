"""The tables of the α-β runouts on real profiles are what the command gives."""

from __future__ import annotations

from pathlib import Path

from benchmarks.alpha_beta import tables
from benchmarks.study import DOCS, with_parts


def test_the_page_is_what_the_command_gives(shared_data: Path) -> None:
    written = (DOCS / "alpha-beta.md").read_text(encoding="utf-8")
    assert with_parts(written, tables(shared_data / "tyrol-profiles")) == written
