"""How much of each part of `make trust` is done, and what all parts share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Tell = Callable[[str], None]
LONGEST_FAULT = 300


@dataclass(frozen=True, slots=True)
class Amounts:
    """How much of each part is done; `only` one command is killed, where it is named."""

    kills: int = 300
    only: str = ""
    cuts: int = 500
    sizes: int = 4
    seconds: float = 60.0
    rows: int = 50_000
    mutants: int = 20_000
    chains: int = 200
    changes: int = 400
    seed: int = 15


def cut(faults: list[str]) -> list[str]:
    """Each fault once, and not too long."""
    return [fault[:LONGEST_FAULT] for fault in dict.fromkeys(faults)]
