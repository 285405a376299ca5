"""What the sections of docs/trust.md are made of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Found = dict[str, Any]


def command(part: str, found: Found, *options: str) -> str:
    """The command that makes a part, with how much of it."""
    given = "".join(f" --{name} {found['amounts'][name]:g}" for name in (*options, "seed"))
    return f"`.venv/bin/python benchmarks/trust.py {part}{given}`"


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> list[str]:
    """A table in Markdown, its first column of words."""
    ruler = ["---", *("--:" for _ in head[1:])]
    lines = [head, ruler, *([_cell(v) for v in row] for row in rows)]
    return [*("| " + " | ".join(line) + " |" for line in lines), ""]


def _cell(value: object) -> str:
    return f"{value:,}" if isinstance(value, int) else str(value)


def listed(faults: Sequence[str], none: str) -> list[str]:
    """The faults, or the sentence that there are none."""
    if not faults:
        return [none, ""]
    shown = [f"- `{fault.replace('`', chr(39))}`".replace("\n", " ") for fault in faults]
    return [f"**{len(faults)} at fault:**", "", *shown, ""]
