"""Changes of whatever a fuzzer has kept of a form, with the words that its readers look for."""

from __future__ import annotations

import ast
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import avahazard
from benchmarks.trust.mutants import mutate_bytes
from benchmarks.trust.sources import Source

LONGEST_WORD = 30


def words_of(modules: Sequence[str]) -> list[str]:
    """The short texts and fields in these modules: names of columns, separators, units, levels."""
    root = Path(avahazard.__file__).parent.parent
    files: list[Path] = []
    for name in modules:
        place = root / name.replace(".", "/")
        files += sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    found: set[str] = set()
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.add(node.value)
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                found.add(node.target.id)
    return sorted(word for word in found if 0 < len(word) <= LONGEST_WORD)


def varied(source: Source, data: bytes, words: Sequence[str], rng: np.random.Generator) -> bytes:
    """`data` changed as files of this form are, or with a word put in; by bytes where it is none.

    A kept input may be no text, table or workbook any more.
    """
    try:
        if rng.random() < 0.3 and not source.file.endswith((".xlsx", ".gpkg", ".tif")):
            return _with_word(data.decode(), words[int(rng.integers(len(words)))], rng).encode()
        return source.mutate(data, rng)
    except (ValueError, KeyError, IndexError, zipfile.BadZipFile, zlib.error, EOFError):
        return mutate_bytes(data, rng)


def _with_word(text: str, word: str, rng: np.random.Generator) -> str:
    """A cell or word of one line (of the first, which names the columns, in half) replaced."""
    lines = text.split("\n")
    k = 0 if rng.random() < 0.5 else int(rng.integers(len(lines)))
    between = max((",", ";", "\t", " ", '"'), key=lines[k].count)
    parts = lines[k].split(between)
    at = int(rng.integers(len(parts)))
    parts[at : at + int(rng.integers(2))] = [word]
    lines[k] = between.join(parts)
    return "\n".join(lines)
