"""Lines of cells, held by column, against the lines themselves."""

from __future__ import annotations

from unittest.mock import patch

from hypothesis import given
from hypothesis import strategies as st

from avahazard.records.files.sheet import Line, Sheet, packed
from avahazard.records.table import _table as named_table
from avahazard.records.table import table_of

WORDS = st.sampled_from(["", "", "7", "17.25", "1950-02-13", "a text of more than 15 bytes: ⛰"])
HEADERS = st.lists(st.sampled_from(["a", "b", "c", "d", ""]), min_size=1, max_size=5).filter(
    lambda names: any(names) and len({n for n in names if n}) == len([n for n in names if n])
)
LINES = st.lists(st.lists(WORDS, max_size=7), max_size=12)


def obvious(
    header: list[str], lines: list[Line]
) -> tuple[list[tuple[int, dict[str, str]]], list[int], set[int]]:
    """Rows with their lines, lines of another length, and columns without a name, one by one."""
    last = max(k for k, name in enumerate(header) if name)
    rows, uneven = [], []
    nameless = set()
    for line, cells in lines:
        filled = [k for k, text in enumerate(cells) if text]
        nameless |= {k for k in filled if k < len(header) and not header[k]}
        if len(cells) <= last or (filled and filled[-1] >= len(header)):
            uneven.append(line)
        else:
            rows.append((line, {header[k]: cells[k] for k in filled}))
    return rows, uneven, nameless


@given(HEADERS, LINES)
def test_columns_hold_what_the_lines_hold(header: list[str], cells: list[list[str]]) -> None:
    lines: list[Line] = [(3 + 2 * k, row) for k, row in enumerate(cells) if any(row)]
    rows, uneven, nameless = obvious(header, lines)
    with (
        patch("avahazard.records.files.sheet.AT_ONCE", 3),
        patch("avahazard.records.table.AT_ONCE", 2),
    ):
        held = packed([(1, header), *lines])
        assert held is not None
        assert held.nameless == nameless
        assert [line for line, _ in held.uneven] == uneven
        table = named_table(Sheet("a.csv", "a", held, ()), [])
        if nameless:
            assert table is None
            return
        assert table is not None
        assert list(table.numbered()) == rows
        wanted = range(len(rows) - 1, -1, -2)
        assert list(table.at(wanted)) == [rows[k] for k in wanted]
        for name in filter(None, header):
            texts = [row.get(name, "") for _, row in rows]
            assert [text for block in table.blocks(name) for text in block] == texts
            assert list(table.values(name)) == [(k, t) for k, t in enumerate(texts) if t]
            some = [(line, {name: row[name]} if name in row else {}) for line, row in rows]
            assert list(table.numbered([name])) == some
        again = table_of("a.csv", table.header, rows)
        assert list(again.numbered()) == rows


def test_a_file_without_a_line_has_no_cells() -> None:
    assert packed([]) is None


@given(HEADERS)
def test_a_header_alone_has_columns_of_no_rows(header: list[str]) -> None:
    held = packed([(1, header)])
    assert held is not None
    assert [len(column) for column in held.columns] == [0] * len([n for n in header if n])
