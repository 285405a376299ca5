"""Mutants of files: what people, programs and broken disks make of them."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
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
        _pick((_change_row, _change_row, _change_column), rng)(rows, rng)
    data = "\n".join(separator.join(row) for row in rows).encode("utf-8", "surrogatepass")
    return mutate_bytes(data, rng) if rng.random() < 0.15 else data


def mutate_text(text: str, rng: Rng) -> bytes:
    """One to three changes of the lines, or of words within lines, of a text."""
    rows = [line.split(" ") for line in text.splitlines()]
    for _ in range(int(rng.integers(1, 4))):
        _change_row(rows, rng)
    return "\n".join(" ".join(row) for row in rows).encode("utf-8", "surrogatepass")


def mutate_bytes(data: bytes, rng: Rng) -> bytes:
    """Bytes that are other ones, missing, doubled, zero, or cut off."""
    changed = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        if (n := len(changed)) == 0:
            break
        at, what = int(rng.integers(n)), int(rng.integers(6))
        part = slice(at, at + int(rng.integers(1, max(2, min(512, n)))))
        if what <= 1:
            changed[at] = int(rng.integers(256))
        elif what == 2:
            del changed[part]
        elif what == 3:
            changed[at:at] = changed[part]
        elif what == 4:
            changed[part] = bytes(len(changed[part]))
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
    if rng.random() < 0.6:  # the value of a cell
        values = parts[name].decode("utf-8").split("<v>")
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


def _change_row(rows: Rows, rng: Rng) -> None:
    """A row left out, doubled, elsewhere or cut off; or, in half, another cell."""
    if not rows:
        rows.append([_pick(CELLS, rng)])
        return
    i, j = (int(rng.integers(len(rows))) for _ in range(2))
    what = int(rng.integers(8))
    if what == 0:
        del rows[i]
    elif what == 1:
        rows.insert(i, list(rows[j]))
    elif what == 2:
        rows[i], rows[j] = rows[j], rows[i]
    elif what == 3:
        del rows[i][int(rng.integers(1, len(rows[i]) + 1)) :]
    elif rows[i]:
        rows[i][int(rng.integers(len(rows[i])))] = _pick(CELLS, rng)


def _change_column(rows: Rows, rng: Rng) -> None:
    """A column left out, filled or scaled, or its heading written otherwise."""
    if not rows or not rows[0]:
        return
    k, what = int(rng.integers(len(rows[0]))), int(rng.integers(4))
    cell, factor = _pick(CELLS, rng), _pick((-1.0, 1e3, 1e-3, 1e9), rng)
    if what == 0:
        name = rows[0][k]
        names = name.upper(), f" {name} ", f"{name} [m]", name[:-1], name.replace("_", " "), ""
        rows[0][k] = _pick((*names, *rows[0]), rng)
    for row in rows[what > 1 :]:
        if what == 1:
            del row[k : k + 1]
        elif what == 2:
            row[k : k + 1] = [cell]
        elif what == 3 and k < len(row):
            row[k] = _scaled(row[k], factor)


def _scaled(cell: str, factor: float) -> str:
    try:
        return f"{factor * float(cell):g}"
    except ValueError:
        return cell


def _pick(items: Sequence[T], rng: Rng) -> T:
    return items[int(rng.integers(len(items)))]
