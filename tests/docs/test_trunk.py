"""The diagram of the trunk is true to the imports; a class has a name of its own."""

from __future__ import annotations

import ast
import re
from collections import Counter

import pytest

from tests.conftest import ROOT

DIAGRAM = (ROOT / "docs/theory/trunk.md").read_text(encoding="utf-8").split("```")[1]
BOX = re.compile(r"^(\S+\.py)", re.MULTILINE)
DOWN = re.compile(r"^(\S+\.py).*\n   │  (\w+).*\n   ▼\n(\S+\.py)", re.MULTILINE)
ASIDE = re.compile(r"^(\S+\.py)  ◄──  (\w+)  ──  (\S+\.py)$", re.MULTILINE)
ARROWS = [
    *(
        (above, name, below)
        for above, name, below in re.findall(f"(?={DOWN.pattern})", DIAGRAM, re.M)
    ),
    *((given, name, box) for box, name, given in ASIDE.findall(DIAGRAM)),
]


def imported(file: str) -> set[tuple[str, str]]:
    """The names that a file imports, each with the file that it is imported from."""
    tree = ast.parse((ROOT / "avahazard" / file).read_text(encoding="utf-8"))
    return {
        (f"{node.module.removeprefix('avahazard.').replace('.', '/')}.py", alias.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }


def test_every_box_has_its_arrows() -> None:
    boxes = BOX.findall(DIAGRAM)
    assert len(boxes) > 10
    assert len(ARROWS) == len(boxes) - 1 + DIAGRAM.count("◄──")


@pytest.mark.parametrize(("above", "name", "below"), ARROWS, ids=str)
def test_an_arrow_is_an_import(above: str, name: str, below: str) -> None:
    """What passes is imported by the one from the other: what it is, or who is called with it."""
    assert (above, name) in imported(below) or (below, name) in imported(above)


def test_no_two_classes_share_a_name() -> None:
    files = sorted((ROOT / "avahazard").rglob("*.py"))
    trees = [ast.parse(file.read_text(encoding="utf-8")) for file in files]
    names = Counter(
        node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef)
    )
    assert [name for name, n in names.items() if n > 1] == []
