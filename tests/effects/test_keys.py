"""Effects alone know effect keys."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

from avahazard.effects.catalogue import catalogue
from avahazard.effects.covariate import PREFIX
from avahazard.inference.model.specification import Specification

PACKAGE = Path(__file__).resolve().parents[2] / "avahazard"
OWN_NAMES = ("effects", "synth")
"""Folders that name effects: the catalogue's, and that of the synthetic datasets."""
SETTINGS = {field.name for field in fields(Specification)}


def _named(tree: ast.AST) -> Iterator[str]:
    """Texts that are a key, or begin with one and a mark; not a setting's field in a document."""
    of_documents = {
        id(part)
        for node in ast.walk(tree)
        for part in (
            node.keys
            if isinstance(node, ast.Dict)
            else [node.slice]
            if isinstance(node, ast.Subscript)
            else []
        )
        if isinstance(part, ast.Constant) and part.value in SETTINGS
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = node.value
            key = text.split(".")[0]
            if (key in catalogue() or text.startswith(PREFIX)) and id(node) not in of_documents:
                yield text


def test_no_key_stands_elsewhere() -> None:
    found = [
        f"{file.relative_to(PACKAGE)}: {text}"
        for file in sorted(PACKAGE.rglob("*.py"))
        if file.relative_to(PACKAGE).parts[0] not in OWN_NAMES
        for text in _named(ast.parse(file.read_text(encoding="utf-8")))
    ]
    assert found == []


def test_a_key_is_seen_where_it_stands() -> None:
    code = 'x = {"snow_type": "snow-type", "centrifugal": d["centrifugal"]}; "covariate:a"'
    code += '; y == "centrifugal"; f"path-effect.tau"; "no season at all"'
    assert set(_named(ast.parse(code))) == {
        "snow-type", "covariate:a", "centrifugal", "path-effect.tau"
    }  # fmt: skip
