"""The parts of `make trust`: each returns what it counted, as plain values for the page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.trust import code_part, fault_parts, guided, input_parts
from benchmarks.trust.amounts import Amounts, Tell

PARTS: dict[str, Callable[[Amounts, Path, Tell], dict[str, Any]]] = {
    "kills": fault_parts.kills,
    "power": fault_parts.power,
    "disks": fault_parts.disks,
    "users": fault_parts.users,
    "upgrades": fault_parts.upgrades,
    "mutants": input_parts.mutants,
    "guided": guided.guided,
    "degenerate": input_parts.degenerate,
    "code": code_part.code,
}

ASKED = ("guided",)
"""Parts that are done where they are named: they need what no lock has."""
MORE = ("kills",)
"""Parts of which runs by other seeds count too: more moments of the same commands."""


def added(name: str, kept: dict[str, Any] | None, run: dict[str, Any]) -> dict[str, Any]:
    """What is kept of a part after a run of it."""
    if name not in MORE:
        return run
    runs = kept["runs"] if kept else []
    others = [one for one in runs if one["amounts"]["seed"] != run["amounts"]["seed"]]
    return {"runs": [*others, run]}
