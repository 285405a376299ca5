"""Mutants of files: what people, programs and broken disks make of them."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

CELLS = (
    "", " ", "-", "nan", "NaN", "inf", "-inf", "1e308", "-1e308", "1e-320", "0", "-0", "-1",
    "1,5", "1.234,5", "1 234", "12'345", "0x1f", "1_000", "٣٤", "½", "TRUE", "None", "NULL",
    "#REF!", "=1+1", "31.02.2001", "2001-13-40", "0000", "9999", "1e5", "x" * 3000, "\x00",
    "\x1b[31m", "\u202e", "é", "'; DROP TABLE events;--", "../../etc/passwd", "\"", "\"\"",
    "a\nb", "P01", "99999999999999999999", "3.14159265358979", "2500", "0.5", "5e-324", "١٢",
    "−5", "10%", "1/2", "<b>", "\ufeff", "~",
)  # fmt: skip
T = TypeVar("T")
Rng = np.random.Generator
Rows = list[list[str]]


def mutate_table(text: str, rng: Rng, separator: str = ",") -> bytes:
    """One to three changes of cells, rows, columns or the header of a table, or of its bytes."""
    rows = [line.split(separator) for line in text.splitlines()]
    for _ in range(int(rng.integers(1, 4))):
        _pick(ROW_CHANGES, rng)(rows, rng)
    data = "\n".join(separator.join(row) for row in rows).encode("utf-8", "surrogatepass")
    return mutate_bytes(data, rng) if rng.random() < 0.15 else data


def mutate_text(text: str, rng: Rng) -> bytes:
    """One to three changes of the lines, or of words within lines, of a text."""
    lines = text.splitlines()
    for _ in range(int(rng.integers(1, 4))):
        k = int(rng.integers(len(lines))) if lines else 0
        what = int(rng.integers(5))
        if not lines:
            lines = [_pick(CELLS, rng)]
        elif what == 0:
            del lines[k]
        elif what == 1:
            lines.insert(k, lines[int(rng.integers(len(lines)))])
        elif what == 2:
            lines[k] = lines[k][: int(rng.integers(len(lines[k]) + 1))]
        else:
            words = lines[k].split(" ")
            words[int(rng.integers(len(words)))] = _pick(CELLS, rng)
            lines[k] = " ".join(words)
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def mutate_bytes(data: bytes, rng: Rng) -> bytes:
    """Bytes that are other ones, missing, doubled, zero, or cut off."""
    changed = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        n = len(changed)
        if n == 0:
            break
        at, what = int(rng.integers(n)), int(rng.integers(6))
        length = int(rng.integers(1, max(2, min(512, n))))
        if what <= 1:
            changed[at] = int(rng.integers(256))
        elif what == 2:
            del changed[at : at + length]
        elif what == 3:
            changed[at:at] = changed[at : at + length]
        elif what == 4:
            changed[at : at + length] = bytes(len(changed[at : at + length]))
        elif rng.random() < 0.3:
            del changed[at:]
    return bytes(changed)


def mutate_workbook(data: bytes, rng: Rng) -> bytes:
    """A workbook with a mutant of one of its parts, or with other bytes."""
    if rng.random() < 0.2:
        return mutate_bytes(data, rng)
    with zipfile.ZipFile(io.BytesIO(data)) as whole:
        parts = {name: whole.read(name) for name in whole.namelist()}
    sheets = [name for name in parts if "sheet" in name or "sharedStrings" in name]
    name = _pick(sheets if rng.random() < 0.7 else list(parts), rng)
    text = parts[name].decode("utf-8")
    if rng.random() < 0.6:  # the value of a cell
        values = text.split("<v>")
        k = int(rng.integers(len(values)))
        head, _, rest = values[k].partition("</v>")
        cell = _pick(CELLS, rng).replace("&", "&amp;").replace("<", "&lt;").replace("\x00", "")
        values[k] = f"{cell}</v>{rest}" if rest else head
        parts[name] = "<v>".join(values).encode("utf-8", "ignore")
    else:
        parts[name] = mutate_bytes(parts[name], rng)
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as target:
        for part, content in parts.items():
            target.writestr(part, content)
    return made.getvalue()


def _cell(rows: Rows, rng: Rng) -> None:
    row = _pick(rows[1:] or rows, rng)
    row[int(rng.integers(len(row)))] = _pick(CELLS, rng)


def _heading(rows: Rows, rng: Rng) -> None:
    head = rows[0]
    k = int(rng.integers(len(head)))
    name = head[k]
    head[k] = _pick(
        (name.upper(), f" {name} ", f"{name} [m]", name[:-1], name.replace("_", " "), "", *head),
        rng,
    )


def _drop_row(rows: Rows, rng: Rng) -> None:
    if len(rows) > 1:
        del rows[int(rng.integers(len(rows)))]


def _double_row(rows: Rows, rng: Rng) -> None:
    rows.insert(int(rng.integers(len(rows))), list(_pick(rows, rng)))


def _swap_rows(rows: Rows, rng: Rng) -> None:
    i, j = rng.integers(len(rows), size=2)
    rows[i], rows[j] = rows[j], rows[i]


def _drop_column(rows: Rows, rng: Rng) -> None:
    k = int(rng.integers(len(rows[0])))
    for row in rows:
        del row[k : k + 1]
        if not row:
            row.append("")


def _fill_column(rows: Rows, rng: Rng) -> None:
    k, cell = int(rng.integers(len(rows[0]))), _pick(CELLS, rng)
    for row in rows[1:]:
        row[k : k + 1] = [cell]


def _scale_column(rows: Rows, rng: Rng) -> None:
    k = int(rng.integers(len(rows[0])))
    factor = _pick(("-", "1e3*", "1e-3*", "1e9*"), rng)
    for row in rows[1:]:
        if k < len(row):
            row[k] = _scaled(row[k], factor)


def _short_row(rows: Rows, rng: Rng) -> None:
    row = _pick(rows, rng)
    del row[int(rng.integers(1, len(row) + 1)) :]


def _scaled(cell: str, factor: str) -> str:
    try:
        value = float(cell)
    except ValueError:
        return cell
    return f"{-value if factor == '-' else float(factor[:-1]) * value:g}"


ROW_CHANGES: tuple[Callable[[Rows, Rng], None], ...] = (
    _cell, _cell, _cell, _cell, _heading, _drop_row, _double_row, _swap_rows, _drop_column,
    _fill_column, _scale_column, _short_row,
)  # fmt: skip


def _pick(items: Sequence[T], rng: Rng) -> T:
    return items[int(rng.integers(len(items)))]
