"""CSV files as tables."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.errors import RowProblem
from avahazard.records.sheet import read_tables
from avahazard.records.table import FileTable


def read(folder: Path, raw: bytes) -> tuple[FileTable | None, list[RowProblem]]:
    """Read `raw` as a file."""
    file = folder / "a.csv"
    file.write_bytes(raw)
    problems: list[RowProblem] = []
    tables = read_tables(file, problems)
    return (tables[0] if tables else None), problems


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize("newline", [b"\n", b"\r\n"])
def test_cells_are_stripped_and_empty_ones_left_out(
    tmp_path: Path, mark: bytes, newline: bytes
) -> None:
    raw = mark + newline.join([b"a, b,c", b"1 ,,Aist\xc3\xa9", b"", b",,", b"4,5,6"])
    table, problems = read(tmp_path, raw)
    assert not problems
    assert table is not None
    assert table.header == ("a", "b", "c")
    rows = [(2, {"a": "1", "c": "Aisté"}), (5, {"a": "4", "b": "5", "c": "6"})]
    assert list(table.numbered()) == rows


def test_lines_are_counted_through_quoted_line_ends(tmp_path: Path) -> None:
    table, problems = read(tmp_path, b'a,b\n"x\ny",2\n3\n4,5\n')
    assert table is not None
    assert list(table.lines) == [2, 5]
    assert [(p.line, p.value) for p in problems] == [(4, "1 values")]


@pytest.mark.parametrize(
    ("raw", "line", "value", "accepted"),
    [
        (b"a,b\n1,2\nM\x81ller,3\n", 3, "byte 0x81", "UTF-8"),
        (b"a,b\n1,\x002\n", 2, "byte 0x00", "UTF-8"),
        (b"", 1, "", "header row"),
        (b"sep=x\na;b\n1;2\n", 1, "x", "semicolons"),
        (b"a,b,a\n", 1, "a", "each column name once"),
        (b"a,,b\n1,2,3\n", 1, "", "a name for column 2"),
        (b'a,b\n"1,2\n', 2, "unexpected end of data", "separated by commas"),
    ],
)
def test_unusable_files_say_why(
    tmp_path: Path, raw: bytes, line: int, value: str, accepted: str
) -> None:
    table, problems = read(tmp_path, raw)
    assert table is None
    assert len(problems) == 1
    assert (problems[0].line, problems[0].value) == (line, value)
    assert accepted in problems[0].accepted


def test_texts_of_a_column_are_counted_but_no_empty_cells(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("avahazard.records.table.AT_ONCE", 2)
    table, _ = read(tmp_path, b"a,b\n1,x\n,x\n2,x\n1,\n1,y\n")
    assert table is not None
    assert table.counts("a") == {"1": 3, "2": 1}
    assert table.counts("b") == {"x": 3, "y": 1}
    assert not table.counts("no such column")
