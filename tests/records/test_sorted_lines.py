"""Lines that are sorted without holding them all."""

from __future__ import annotations

import random

import pytest

from avahazard.records import sorted_lines
from avahazard.records.sorted_lines import SortedLines


@pytest.mark.parametrize(("held", "files"), [(0, 7), (0, 300), (40, 64), (10_000, 64)])
def test_they_come_out_sorted(monkeypatch: pytest.MonkeyPatch, held: int, files: int) -> None:
    monkeypatch.setattr(sorted_lines, "HELD_BYTES", held)
    monkeypatch.setattr(sorted_lines, "MOST_FILES", files)
    rng = random.Random(0)
    # One may begin another, and come twice.
    texts = ["".join(rng.choices(' "az', k=rng.randrange(6))) for _ in range(200)]
    lines = SortedLines()
    for text in texts:
        lines.add(text)
    assert lines.count == 200
    assert len(lines._files) <= files
    assert list(lines.read()) == [text.encode() + b"\n" for text in sorted(texts)]
    assert (lines.count, list(lines.read())) == (0, [])


def test_files_are_closed_where_reading_ends_early(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sorted_lines, "HELD_BYTES", 0)
    lines = SortedLines()
    for text in "bac":
        lines.add(text)
    files = list(lines._files)
    reader = lines.read()
    assert next(reader) == b"a\n"
    reader.close()
    assert len(files) == 3
    assert all(file.closed for file in files)
