"""Run the tutorials: every block of commands as it stands on the page, in the page's order.

Blocks of ```sh are commands, blocks of ```python cells of one notebook. A block of ```text after
them shows what they printed, and is written anew; so are the pictures that the page shows. A block
with a title, such as ```toml title="limits.toml", is a file that the commands use.
Run from the root of the checkout: make tutorial
"""

from __future__ import annotations

import ast
import contextlib
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "tutorial"
FENCE = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
PICTURE = re.compile(r"!\[[^\]]*\]\(([^)]+\.png)\)")


@dataclass(frozen=True, slots=True)
class Block:
    """A fenced block of a page: its language, its title, and where its text stands."""

    language: str
    title: str | None
    text: str
    start: int
    end: int


def blocks(page: str) -> Iterator[Block]:
    """The fenced blocks of a page, in order."""
    for found in FENCE.finditer(page):
        yield Block(found[1], found[2], found[3], found.start(3), found.end(3))


def run_commands(commands: str, folder: Path) -> str:
    """Run the lines of a block; return what they print. A line that fails stops it."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    kept = {k: v for k, v in os.environ.items() if not k.startswith("AVAHAZARD_")}
    done = subprocess.run(
        ["sh", "-ec", commands],
        cwd=folder,
        env={**kept, "PATH": path, "COLUMNS": "80"},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(f"{commands}\n{done.stdout}{done.stderr}")
    return "\n".join(line.rstrip() for line in done.stdout.strip("\n").splitlines()) + "\n"


def run_cell(code: str, names: dict[str, object], folder: Path) -> str:
    """Run a cell in `folder` with the names of the cells before.

    Returns what it prints, and the value of its last expression.
    """
    body = ast.parse(code).body
    last = body.pop() if isinstance(body[-1], ast.Expr) else None
    out = io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(out):
        exec(compile(ast.Module(body, []), "cell", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
            if value is not None:
                print(value)
    return out.getvalue()


def run_page(page: str, folder: Path) -> str:
    """Run a page in `folder`; return it with the outputs that it now has."""
    parts, at, printed = [], 0, ""
    names: dict[str, object] = {}
    for block in blocks(page):
        if block.title is not None:
            (folder / block.title).write_text(block.text, encoding="utf-8")
        elif block.language == "sh":
            printed = run_commands(block.text, folder)
        elif block.language == "python":
            printed = run_cell(block.text, names, folder)
        elif block.language == "text":
            parts += [page[at : block.start], printed]
            at = block.end
    return "".join(parts) + page[at:]


def pictures(page: str) -> list[str]:
    """Names of the pictures that a page shows."""
    return PICTURE.findall(page)


def main() -> None:
    """Run the pages named on the command line, else all; write outputs and pictures."""
    for file in [Path(name) for name in sys.argv[1:]] or sorted(FOLDER.glob("*.md")):
        print(f"Running {file.name}", flush=True)
        with tempfile.TemporaryDirectory() as name:
            page = run_page(file.read_text(encoding="utf-8"), Path(name))
            file.write_text(page, encoding="utf-8")
            for picture in pictures(page):
                shutil.copy(Path(name) / picture, file.parent / picture)


if __name__ == "__main__":
    main()
