"""What code and pages refer to is there for every reader: our own pages."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MADE = {"docs/commands.md", "docs/effects.md", "docs/api.md"}
"""Pages that are made from the program when the site is built."""


def texts() -> dict[str, str]:
    """What people read in the tree: code with its docstrings, pages, templates."""
    files = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
    for folder in ("avahazard", "benchmarks", "docs", "migrations", "tests"):
        files += [
            file
            for file in (ROOT / folder).rglob("*")
            if file.suffix in {".py", ".md", ".html", ".css", ".js"} and file != Path(__file__)
        ]
    return {str(f.relative_to(ROOT)): f.read_text(encoding="utf-8") for f in files}


def test_nothing_refers_to_papers_outside_the_tree() -> None:
    # "contract" in quotes is a flag of the compiler.
    outside = re.compile(r"\bDESIGN\b|(?<!\")\b[Cc]ontract(?:'s|s)?\b(?!\")")
    found = {name: outside.findall(text) for name, text in texts().items()}
    assert {name: words for name, words in found.items() if words} == {}


def test_pages_that_docstrings_name_are_there() -> None:
    named = {
        (name, page)
        for name, text in texts().items()
        if name.endswith(".py")
        for page in re.findall(r"\bdocs/[\w/]+\.md\b", text)
    }
    assert len(named) > 15
    assert {(n, p) for n, p in named if p not in MADE and not (ROOT / p).exists()} == set()
