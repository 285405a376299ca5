"""What mkdocs runs: pages made from the program itself and from files outside docs/, equations."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from api_page import api_page
from commands_page import commands_page
from effects_page import effects_page
from equations import with_equations
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]

COPIED = {
    "index.md": "README.md",
    "contributing.md": "CONTRIBUTING.md",
    "changelog.md": "CHANGELOG.md",
    "security.md": "SECURITY.md",
    "twin.md": "data/README.md",
}
MADE: dict[str, Callable[[], str]] = {
    "commands.md": commands_page,
    "effects.md": effects_page,
    "api.md": api_page,
}
# Links as they are in the tree, and what they are on the site.
LINKS = {
    "](docs/": "](",
    "](data/README.md": "](twin.md",
    "](../data/README.md": "](twin.md",
    "](../../data/README.md": "](../twin.md",
    "](CONTRIBUTING.md": "](contributing.md",
    "](CHANGELOG.md": "](changelog.md",
    "](SECURITY.md": "](security.md",
    "](README.md": "](index.md",
    "[CITATION.cff](CITATION.cff)": "`CITATION.cff`",
}


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that are not files of docs/."""
    for name, source in COPIED.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, name, content=text))
    for name, make in MADE.items():
        files.append(File.generated(config, name, content=make()))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Turn links into those of the site, and equations into MathML."""
    for old, new in LINKS.items():
        markdown = markdown.replace(old, new)
    return with_equations(markdown)
