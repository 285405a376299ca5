"""The parts of `make trust`: each returns what it counted, as plain values for the page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.trust import fault_parts, input_parts
from benchmarks.trust.amounts import Amounts, Tell

PARTS: dict[str, Callable[[Amounts, Path, Tell], dict[str, Any]]] = {
    "kills": fault_parts.kills,
    "power": fault_parts.power,
    "disks": fault_parts.disks,
    "users": fault_parts.users,
    "upgrades": fault_parts.upgrades,
    "mutants": input_parts.mutants,
    "degenerate": input_parts.degenerate,
}
