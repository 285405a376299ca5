"""What is counted over the lines of results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

Line = dict[str, Any]
SEEN = 10.0
"""Gain (nats) over which an oracle detects an effect."""


def alarm(x: Line) -> bool:
    """Whether something is named, and nothing that is true or harmless with it."""
    return bool(x["missing"]) and not set(x["missing"]) & {*x["true"], *x["neutral"]}


def in_set(x: Line) -> bool:
    """Whether a true effect is named or in the set."""
    return bool(set(x["missing"]) & set(x["true"]))


def first_alone(x: Line) -> bool:
    """Whether one effect is named, and it is right."""
    return len(x["missing"]) == 1 and x["missing"][0] in x["true"]


def one_named(x: Line) -> bool:
    """Whether one effect is named alone."""
    return len(x["missing"]) == 1


def share(lines: Sequence[Line], is_so: Callable[[Line], bool]) -> str:
    """The share of lines that are so, with its counts."""
    if not lines:
        return "-"
    n = sum(bool(is_so(x)) for x in lines)
    return f"{100.0 * n / len(lines):.0f} % ({n}/{len(lines)})"
